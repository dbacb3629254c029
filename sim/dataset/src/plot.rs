//! The distribution of the deformation loss by intensity (paper Fig. 7).

use std::path::{Path, PathBuf};

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use whole_file::Draft;

use crate::error::DatasetError;
use crate::folder::Folder;
use crate::manifest::Row;

const SIZE_PX: (u32, u32) = (960, 640);
/// Losses at which each density is evaluated.
const LEVELS: usize = 96;
/// Half the width of the widest violin, as a share of the distance between two.
const HALF_WIDTH: f64 = 0.42;
const FONT: &str = "sans-serif";
const FILL: RGBColor = RGBColor(86, 130, 178);
const LINE: RGBColor = RGBColor(32, 60, 96);

/// Paths of the plots: one for each object, in this order, then one for all objects together.
pub fn paths<'a>(folder: &Folder, objects: impl Iterator<Item = &'a str>) -> Vec<PathBuf> {
    let of_object = |object| folder.root().join(format!("losses-{object}.png"));
    let mut paths: Vec<PathBuf> = objects.map(of_object).collect();
    paths.push(folder.root().join("losses.png"));
    paths
}

/// Draws the plots of all objects in the rows, which are sorted by object.
///
/// # Errors
/// A file cannot be written.
pub fn draw_all(folder: &Folder, rows: &[Row]) -> Result<Vec<PathBuf>, DatasetError> {
    let groups: Vec<&[Row]> = rows.chunk_by(|a, b| a.object == b.object).collect();
    let names = groups.iter().map(|group| group[0].object.as_str());
    let paths = paths(folder, names.clone());
    for ((path, group), name) in paths.iter().zip(&groups).zip(names) {
        draw(path, name, group)?;
    }
    let title = match groups.len() {
        1 => groups[0][0].object.clone(),
        count => format!("{count} objects"),
    };
    if let Some(path) = paths.last() {
        draw(path, &title, rows)?;
    }
    Ok(paths)
}

/// One violin for each asked intensity, with the quartiles and the median.
fn draw(path: &Path, title: &str, rows: &[Row]) -> Result<(), DatasetError> {
    let refuse = |reason: String| DatasetError::Plot {
        path: path.to_path_buf(),
        reason,
    };
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font(FONT, FontStyle::Normal, font)
        .map_err(|_| refuse("its font is damaged".to_owned()))?;
    let draft = Draft::of(path).map_err(DatasetError::io("write", path))?;
    let area = BitMapBackend::new(draft.path(), SIZE_PX).into_drawing_area();
    let meshes = rows.iter().filter(|row| row.has_mesh()).count();
    let title = format!("{title}: {meshes} meshes");
    fill(&area, &title, &by_intensity(rows))
        .and_then(|()| area.present())
        .map_err(|error| refuse(error.to_string()))?;
    drop(area);
    draft.finish().map_err(DatasetError::io("write", path))
}

/// Asked intensity in mm, and the losses of its meshes, rising.
type Group = (f64, Vec<f64>);

fn by_intensity(rows: &[Row]) -> Vec<Group> {
    let made = rows.iter().filter(|row| row.has_mesh());
    let mut asked: Vec<f64> = made.map(|row| row.asked_mm).collect();
    asked.sort_by(f64::total_cmp);
    asked.dedup();
    let losses = |asked_mm: f64| {
        let same = rows.iter().filter(|row| row.asked_mm == asked_mm);
        let mut losses: Vec<f64> = same.filter_map(|row| row.loss).collect();
        losses.sort_by(f64::total_cmp);
        (asked_mm, losses)
    };
    asked.into_iter().map(losses).collect()
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;
type DrawResult<'a> =
    Result<(), DrawingAreaErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

fn fill<'a>(area: &Area<'a>, title: &str, groups: &[Group]) -> DrawResult<'a> {
    let highest = groups.iter().filter_map(|(_, losses)| losses.last());
    let top = 1.05 * highest.copied().fold(f64::MIN_POSITIVE, f64::max);
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 24))
        .margin(16)
        .x_label_area_size(52)
        .y_label_area_size(80)
        .build_cartesian_2d(-0.6..groups.len() as f64 - 0.4, 0.0..top)?;
    let name = |x: &f64| {
        let group = groups.get(x.round() as usize);
        let label = group.filter(|_| x.fract() == 0.0 && *x >= 0.0);
        label.map_or(String::new(), |(asked_mm, _)| {
            format!("{}", asked_mm.round())
        })
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .max_light_lines(0)
        .x_labels(2 * groups.len() + 1)
        .x_label_formatter(&name)
        .y_label_formatter(&|loss| format!("{}", (loss * 1e6).round() / 1e6))
        .x_desc("asked intensity (mm)")
        .y_desc("deformation loss")
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 18))
        .draw()?;
    for (index, (_, losses)) in groups.iter().enumerate() {
        let x = index as f64;
        let outline = violin(x, losses, top);
        chart.draw_series([Polygon::new(outline.clone(), FILL.mix(0.6))])?;
        let closed = outline.iter().chain(outline.first()).copied();
        chart.draw_series(LineSeries::new(closed, &LINE))?;
        let quartile = |share: f64| losses[(share * (losses.len() - 1) as f64).round() as usize];
        let box_line = [(x, quartile(0.25)), (x, quartile(0.75))];
        chart.draw_series(LineSeries::new(box_line, LINE.stroke_width(7)))?;
        chart.draw_series([Circle::new((x, quartile(0.5)), 4, WHITE.filled())])?;
    }
    Ok(())
}

/// Outline of a Gaussian kernel density with Silverman's bandwidth, mirrored about `x`.
fn violin(x: f64, losses: &[f64], top: f64) -> Vec<(f64, f64)> {
    let count = losses.len() as f64;
    let mean = losses.iter().sum::<f64>() / count;
    let variance = losses.iter().map(|loss| (loss - mean).powi(2)).sum::<f64>() / count;
    let bandwidth = (1.06 * variance.sqrt() * count.powf(-0.2)).max(0.002 * top);
    let (low, high) = (losses[0], losses[losses.len() - 1]);
    let levels: Vec<f64> = (0..LEVELS)
        .map(|level| low + (high - low) * level as f64 / (LEVELS - 1) as f64)
        .collect();
    let kernel = |level: f64, loss: f64| (-0.5 * ((level - loss) / bandwidth).powi(2)).exp();
    let densities: Vec<f64> = levels
        .iter()
        .map(|&level| losses.iter().map(|&loss| kernel(level, loss)).sum())
        .collect();
    let widest = densities.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let side = |sign: f64| {
        let point = move |(&level, density): (&f64, &f64)| {
            (x + sign * HALF_WIDTH * density / widest, level)
        };
        levels.iter().zip(&densities).map(point).collect::<Vec<_>>()
    };
    let mut outline = side(1.0);
    outline.extend(side(-1.0).into_iter().rev());
    outline
}
