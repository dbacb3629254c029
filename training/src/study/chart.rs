//! The study as plots (paper, Fig. 8 and 9).

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};
use whole_file::Draft;

use super::Cell;
use crate::evaluation::confusion::Confusion;
use crate::training::epoch::EpochReport;

const FONT: &str = "sans-serif";
const COLOURS: [RGBColor; 6] = [
    RGBColor(196, 78, 82),
    RGBColor(221, 132, 82),
    RGBColor(85, 168, 104),
    RGBColor(56, 96, 156),
    RGBColor(129, 114, 179),
    RGBColor(120, 120, 120),
];
const BAR: RGBColor = RGBColor(86, 130, 178);

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

/// Where the plots are.
pub(super) struct Images {
    /// One plot for each number of points, with that number.
    pub curves: Vec<(usize, PathBuf)>,
    pub sizes: PathBuf,
    /// One plot for each cell of the study.
    pub confusions: Vec<PathBuf>,
}

/// Draws all.
pub(super) fn draw_all(folder: &Path, cells: &[Cell]) -> Result<Images> {
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font(FONT, FontStyle::Normal, font).map_err(|_| anyhow!("the font is damaged"))?;
    let mut points: Vec<usize> = cells.iter().map(|cell| cell.points).collect();
    points.sort_unstable();
    points.dedup();
    let mut curves = Vec::new();
    for n in points {
        let path = folder.join(format!("curves-N{n}.png"));
        let of_n: Vec<&Cell> = cells.iter().filter(|cell| cell.points == n).collect();
        draw(&path, (1100, 460), |area| draw_curves(area, &of_n))?;
        curves.push((n, path));
    }
    let sizes = folder.join("sizes.png");
    draw(&sizes, (1100, 400), |area| draw_sizes(area, cells))?;
    let mut confusions = Vec::new();
    for cell in cells {
        let path = folder.join(format!("confusion-{}.png", cell.name()));
        let title = format!(
            "F = {}, N = {}: {:.1} %",
            cell.features,
            cell.points,
            100.0 * cell.accuracy()
        );
        draw(&path, (560, 610), |area| {
            draw_confusion(area, &title, cell.confusion())
        })?;
        confusions.push(path);
    }
    Ok(Images {
        curves,
        sizes,
        confusions,
    })
}

/// Draws a plot into a file that is written whole or not at all.
fn draw(
    path: &Path,
    size_px: (u32, u32),
    fill: impl for<'a> FnOnce(&Area<'a>) -> Drawn<'a>,
) -> Result<()> {
    let refuse_write = || format!("cannot write {}", path.display());
    let draft = Draft::of(path).with_context(refuse_write)?;
    let refuse = |error: String| anyhow!("cannot draw {}: {error}", path.display());
    {
        let area = BitMapBackend::new(draft.path(), size_px).into_drawing_area();
        area.fill(&WHITE)
            .map_err(|error| refuse(error.to_string()))?;
        fill(&area).map_err(|error| refuse(error.to_string()))?;
        area.present().map_err(|error| refuse(error.to_string()))?;
    }
    draft.finish().with_context(refuse_write)
}

/// Accuracy and loss of the validation clouds by epoch, one line a number of features (Fig. 8a).
fn draw_curves<'a>(area: &Area<'a>, cells: &[&Cell]) -> Drawn<'a> {
    let (left, right) = area.split_horizontally(550);
    let percent = |report: &EpochReport| 100.0 * report.validation_accuracy;
    draw_lines(
        &left,
        "validation accuracy (%)",
        cells,
        percent,
        Some(100.0),
    )?;
    draw_lines(
        &right,
        "validation loss",
        cells,
        |report| report.validation_loss,
        None,
    )
}

fn draw_lines<'a>(
    area: &Area<'a>,
    title: &str,
    cells: &[&Cell],
    value: impl Fn(&EpochReport) -> f64,
    top: Option<f64>,
) -> Drawn<'a> {
    let reports = || cells.iter().flat_map(|cell| &cell.results.history);
    let epochs = reports()
        .map(|report| report.epoch)
        .max()
        .unwrap_or(1)
        .max(2) as f64;
    let highest = reports().map(&value).fold(f64::MIN_POSITIVE, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .caption(title, (FONT, 20))
        .build_cartesian_2d(1.0..epochs, 0.0..top.unwrap_or(1.05 * highest))?;
    chart
        .configure_mesh()
        .max_light_lines(0)
        .x_desc("epoch")
        .x_label_formatter(&|epoch| format!("{epoch:.0}"))
        .y_label_formatter(&|value| format!("{}", (value * 1e6).round() / 1e6))
        .label_style((FONT, 15))
        .axis_desc_style((FONT, 16))
        .draw()?;
    for (index, cell) in cells.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let points = cell.results.history.iter();
        let points = points.map(|report| (report.epoch as f64, value(report)));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(format!("F = {}", cell.features))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(3)));
    }
    let corner = match top {
        Some(_) => SeriesLabelPosition::LowerRight,
        None => SeriesLabelPosition::UpperRight,
    };
    chart
        .configure_series_labels()
        .position(corner)
        .background_style(WHITE.mix(0.85))
        .label_font((FONT, 15))
        .draw()
}

/// Size of the model file and number of trainable values by number of features (Fig. 8b).
fn draw_sizes<'a>(area: &Area<'a>, cells: &[Cell]) -> Drawn<'a> {
    // The sizes do not depend on the number of points, except for a digit in the metadata.
    let mut largest: Vec<&Cell> = Vec::new();
    for cell in cells {
        match largest
            .iter_mut()
            .find(|found| found.features == cell.features)
        {
            Some(found) if found.results.model_bytes < cell.results.model_bytes => *found = cell,
            Some(_) => {}
            None => largest.push(cell),
        }
    }
    let (left, right) = area.split_horizontally(550);
    let kilobytes = |cell: &Cell| cell.results.model_bytes as f64 / 1000.0;
    draw_bars(&left, "model file (kB)", &largest, kilobytes)?;
    let hundreds = |cell: &Cell| cell.results.parameter_count as f64 / 100.0;
    draw_bars(
        &right,
        "trainable parameters (hundreds)",
        &largest,
        hundreds,
    )
}

fn draw_bars<'a>(
    area: &Area<'a>,
    title: &str,
    cells: &[&Cell],
    value: impl Fn(&Cell) -> f64,
) -> Drawn<'a> {
    let values: Vec<f64> = cells.iter().map(|cell| value(cell)).collect();
    let top = 1.15 * values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .caption(title, (FONT, 20))
        .build_cartesian_2d(-0.5..cells.len() as f64 - 0.5, 0.0..top)?;
    let name = |x: &f64| {
        let cell = cells
            .get(x.round() as usize)
            .filter(|_| x.fract() == 0.0 && *x >= 0.0);
        cell.map_or(String::new(), |cell| format!("F = {}", cell.features))
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .max_light_lines(0)
        .x_labels(2 * cells.len() + 1)
        .x_label_formatter(&name)
        .y_label_formatter(&|value| format!("{value:.0}"))
        .label_style((FONT, 15))
        .draw()?;
    let style = TextStyle::from((FONT, 16)).pos(Pos::new(HPos::Center, VPos::Bottom));
    for (index, &value) in values.iter().enumerate() {
        let x = index as f64;
        let bar = Rectangle::new([(x - 0.3, 0.0), (x + 0.3, value)], BAR.filled());
        chart.draw_series([bar])?;
        let text = Text::new(format!("{value:.1}"), (x, value), style.clone());
        chart.draw_series([text])?;
    }
    Ok(())
}

/// A row a true class, a column an answer, each cell the share of its row (Fig. 9).
fn draw_confusion<'a>(area: &Area<'a>, title: &str, confusion: &Confusion) -> Drawn<'a> {
    const LEFT: i32 = 100;
    const TOP: i32 = 12;
    const BELOW: i32 = 100;
    let area = area.titled(title, (FONT, 20))?;
    let (width, height) = area.dim_in_pixel();
    let side = (width as i32 - LEFT - 10).min(height as i32 - TOP - BELOW);
    let step = side / confusion.labels.len().max(1) as i32;
    let centred = Pos::new(HPos::Center, VPos::Center);
    let right = TextStyle::from((FONT, 14)).pos(Pos::new(HPos::Right, VPos::Center));
    let turned = TextStyle::from((FONT, 14).into_font().transform(FontTransform::Rotate270));
    let turned = turned.pos(Pos::new(HPos::Right, VPos::Center));
    for (row, (label, counts)) in confusion.labels.iter().zip(&confusion.counts).enumerate() {
        let y = TOP + row as i32 * step;
        let x = LEFT + row as i32 * step;
        area.draw(&Text::new(
            label.clone(),
            (LEFT - 6, y + step / 2),
            right.clone(),
        ))?;
        let below = (x + step / 2, TOP + step * confusion.labels.len() as i32 + 6);
        area.draw(&Text::new(label.clone(), below, turned.clone()))?;
        let whole = counts.iter().sum::<u32>().max(1);
        for (column, &count) in counts.iter().enumerate() {
            let share = f64::from(count) / f64::from(whole);
            let x = LEFT + column as i32 * step;
            let corners = [(x, y), (x + step - 1, y + step - 1)];
            area.draw(&Rectangle::new(corners, BAR.mix(share).filled()))?;
            area.draw(&Rectangle::new(
                corners,
                RGBColor(220, 220, 220).stroke_width(1),
            ))?;
            if count > 0 {
                let style = TextStyle::from((FONT, 14)).pos(centred);
                let text = format!("{:.1}", 100.0 * share);
                area.draw(&Text::new(text, (x + step / 2, y + step / 2), style))?;
            }
        }
    }
    Ok(())
}
