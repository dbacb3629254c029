//! Accuracy, time and size by number of taught objects.

use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use crate::measure::Row;

const FONT: &str = "sans-serif";
const COLOURS: [RGBColor; 3] = [
    RGBColor(196, 78, 82),
    RGBColor(56, 96, 156),
    RGBColor(85, 168, 104),
];

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
/// A name, and a value for each row that has one.
type Line<'a> = (&'a str, fn(&Row) -> Option<f64>);

/// Draws three plots beside each other.
pub fn draw(file: &Path, rows: &[Row]) -> Result<()> {
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font(FONT, FontStyle::Normal, font).map_err(|_| anyhow!("the font is damaged"))?;
    let area = BitMapBackend::new(file, (1320, 400)).into_drawing_area();
    area.fill(&WHITE)?;
    let parts = area.split_evenly((1, 3));
    let percent: [Line; 3] = [
        ("the eight", |row| Some(100.0 * row.old_right)),
        ("taught", |row| {
            (row.taught > 0).then_some(100.0 * row.new_right)
        }),
        ("AUROC of strangers", |row| Some(100.0 * row.auroc[0])),
    ];
    let time: [Line; 2] = [
        ("mesh, dents and views", |row| {
            (row.taught > 0).then_some(row.seconds[0])
        }),
        ("model", |row| (row.taught > 0).then_some(row.seconds[1])),
    ];
    let size: [Line; 1] = [("model", |row| Some(row.model_bytes as f64 / 1e3))];
    lines(&parts[0], "named rightly, %", 90.0..100.0, rows, &percent)?;
    lines(&parts[1], "time for an object, s", 0.0..60.0, rows, &time)?;
    lines(&parts[2], "size, kB", 0.0..110.0, rows, &size)?;
    area.present()?;
    Ok(())
}

fn lines(
    area: &Area,
    title: &str,
    range: std::ops::Range<f64>,
    rows: &[Row],
    lines: &[Line],
) -> Result<()> {
    let most = rows.last().map_or(1, |row| row.taught).max(1);
    let values = lines
        .iter()
        .flat_map(|(_, value)| rows.iter().filter_map(value));
    let (least, largest) = values.fold((range.start, range.end), |(least, largest), value| {
        (least.min(value.floor()), largest.max(value.ceil()))
    });
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(50)
        .caption(title, (FONT, 20))
        .build_cartesian_2d(0.0..most as f64, least..largest)?;
    chart
        .configure_mesh()
        .max_light_lines(0)
        .x_desc("taught objects")
        .x_label_formatter(&|count| format!("{count:.0}"))
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 16))
        .draw()?;
    for ((name, value), colour) in lines.iter().zip(COLOURS) {
        let points = rows
            .iter()
            .filter_map(|row| Some((row.taught as f64, value(row)?)));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .label_font((FONT, 15))
        .draw()?;
    Ok(())
}
