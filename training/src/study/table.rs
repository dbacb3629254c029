//! The study as tables.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;

use super::Cell;
use crate::network::export::write_whole;

#[derive(Serialize)]
struct CellRow {
    features: usize,
    points: usize,
    test_accuracy: f64,
    test_loss: Option<f64>,
    model_bytes: u64,
    parameters: usize,
    epochs: usize,
    run: String,
}

#[derive(Serialize)]
struct EpochRow {
    features: usize,
    points: usize,
    epoch: usize,
    train_loss: f64,
    train_accuracy: f64,
    validation_loss: f64,
    validation_accuracy: f64,
}

#[derive(Serialize)]
struct AnswerRow<'a> {
    features: usize,
    points: usize,
    truth: &'a str,
    prediction: &'a str,
    count: u32,
}

/// Writes cells.csv, curves.csv and confusions.csv.
pub(super) fn write(folder: &Path, cells: &[Cell]) -> Result<()> {
    let rows = cells.iter().map(|cell| CellRow {
        features: cell.features,
        points: cell.points,
        test_accuracy: cell.accuracy(),
        test_loss: cell.loss(),
        model_bytes: cell.results.model_bytes,
        parameters: cell.results.parameter_count,
        epochs: cell.results.history.len(),
        run: cell.results.run_id.clone(),
    });
    write_rows(&folder.join("cells.csv"), rows)?;
    write_rows(&folder.join("curves.csv"), cells.iter().flat_map(epochs))?;
    write_rows(
        &folder.join("confusions.csv"),
        cells.iter().flat_map(answers),
    )
}

fn epochs(cell: &Cell) -> impl Iterator<Item = EpochRow> {
    cell.results.history.iter().map(|report| EpochRow {
        features: cell.features,
        points: cell.points,
        epoch: report.epoch,
        train_loss: report.train_loss,
        train_accuracy: report.train_accuracy,
        validation_loss: report.validation_loss,
        validation_accuracy: report.validation_accuracy,
    })
}

fn answers(cell: &Cell) -> impl Iterator<Item = AnswerRow<'_>> {
    let confusion = cell.confusion();
    let rows = confusion.labels.iter().zip(&confusion.counts);
    rows.flat_map(move |(truth, counts)| {
        let columns = confusion.labels.iter().zip(counts);
        columns.map(move |(prediction, &count)| AnswerRow {
            features: cell.features,
            points: cell.points,
            truth,
            prediction,
            count,
        })
    })
}

fn write_rows(path: &Path, rows: impl Iterator<Item = impl Serialize>) -> Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    write_whole(path, &writer.into_inner()?)
}
