//! The study as one page that needs no other file.

use std::path::Path;

use anyhow::{Context, Result};
use base64::{Engine, engine::general_purpose::STANDARD};

use super::chart::Images;
use super::{Cell, StudyOrder};
use crate::network::export::write_whole;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:1120px;margin:2em auto;padding:0 1em;color:#222}\
table{border-collapse:collapse}td,th{padding:.3em .7em;border:1px solid #ddd;text-align:right}\
img{max-width:100%}.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(260px,1fr));gap:.5em}\
code{background:#f3f3f3}";

/// Writes report.html.
pub(super) fn write(
    folder: &Path,
    order: &StudyOrder,
    cells: &[Cell],
    images: &Images,
) -> Result<()> {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Design choices of the classifier\
         </title><style>{STYLE}</style></head><body>\n<h1>Design choices of the classifier</h1>\n{}",
        introduction(order, cells)
    );
    page += "<h2>Accuracy on the test clouds (%)</h2>\n";
    page += &accuracies(order, cells);
    page += "<h2>Training (Fig. 8a)</h2>\n";
    for (points, path) in &images.curves {
        page += &format!("<h3>N = {points}</h3>\n{}", image(path, "training curves")?);
    }
    page += &format!(
        "<h2>Size (Fig. 8b)</h2>\n{}",
        image(&images.sizes, "sizes")?
    );
    page += "<h2>Confusion (Fig. 9)</h2>\n<p>Rows: what it is; columns: what it was called; % of the row.</p>\n\
             <div class=\"grid\">\n";
    for path in &images.confusions {
        page += &image(path, "confusion matrix")?;
    }
    page += "</div>\n</body></html>\n";
    write_whole(&folder.join("report.html"), page.as_bytes())
}

fn introduction(order: &StudyOrder, cells: &[Cell]) -> String {
    let folders: Vec<String> = order
        .datasets
        .iter()
        .map(|folder| format!("<code>{}</code>", escaped(&folder.display().to_string())))
        .collect();
    let Some(Cell { results, .. }) = cells.first() else {
        return String::new();
    };
    let tested = results.test.as_ref().map_or(0, |test| test.clouds);
    format!(
        "<p>The paper's network with F features on N points, trained on full views of the meshes in {}: {} clouds to \
         learn from, {} to choose the epoch by, {tested} to test on, of grasps that are in no other part. At most {} \
         epochs of Adam, batches of {}, seed {}. Numbers are in <code>cells.csv</code>, <code>curves.csv</code> and \
         <code>confusions.csv</code>.</p>\n",
        folders.join(", "),
        results.train_clouds,
        results.validation_clouds,
        order.settings.training.epochs,
        order.settings.training.batch_size,
        order.settings.seed,
    )
}

fn accuracies(order: &StudyOrder, cells: &[Cell]) -> String {
    let titles: String = order
        .points
        .iter()
        .map(|n| format!("<th>N = {n}</th>"))
        .collect();
    let mut table = format!("<table><tr><th></th>{titles}<th>kB</th><th>parameters</th></tr>\n");
    for row in cells.chunks(order.points.len()) {
        let shares = row
            .iter()
            .map(|cell| format!("<td>{:.2}</td>", 100.0 * cell.accuracy()));
        table += &format!(
            "<tr><th>F = {}</th>{}<td>{:.1}</td><td>{}</td></tr>\n",
            row[0].features,
            shares.collect::<String>(),
            row[0].results.model_bytes as f64 / 1000.0,
            row[0].results.parameter_count
        );
    }
    table + "</table>\n"
}

fn image(path: &Path, what: &str) -> Result<String> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let data = STANDARD.encode(bytes);
    Ok(format!(
        "<img alt=\"{what}\" src=\"data:image/png;base64,{data}\">\n"
    ))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
