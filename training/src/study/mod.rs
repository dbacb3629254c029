//! The study of design choices (paper, Sec. VI-B): the paper's network with each number of features on each number of
//! points.

mod chart;
mod html;
mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use crate::code;
use crate::data::source::Source;
use crate::evaluation::confusion::Confusion;
use crate::network::backend::Backend;
use crate::network::export::write_whole;
use crate::progress::Stage;
use crate::run::{Order, Results, run, run_id};
use crate::settings::Settings;

/// What to study.
#[derive(Debug, Clone)]
pub struct StudyOrder {
    /// Settings of every cell, except F and N.
    pub settings: Settings,
    /// Dataset folders.
    pub datasets: Vec<PathBuf>,
    /// Numbers of features, F.
    pub features: Vec<usize>,
    /// Numbers of points, N.
    pub points: Vec<usize>,
    /// Folder for the results.
    pub output: PathBuf,
    /// What runs the networks.
    pub backend: Backend,
}

/// One combination of F and N, and the results of its training.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Cell {
    /// F, number of features.
    pub features: usize,
    /// N, number of points.
    pub points: usize,
    /// Results of the training.
    pub results: Results,
    /// Digest of the code that trained it; empty in files of versions that did not write it.
    #[serde(default)]
    pub code: String,
}

impl Cell {
    /// The cell's name in file names.
    fn name(&self) -> String {
        name(self.features, self.points)
    }

    /// Answers about the test clouds.
    fn confusion(&self) -> &Confusion {
        self.results
            .test
            .as_ref()
            .map_or(&self.results.confusion, |test| &test.confusion)
    }

    /// Share of the test clouds named rightly.
    pub fn accuracy(&self) -> f64 {
        self.confusion().accuracy()
    }

    fn loss(&self) -> Option<f64> {
        self.results.test.as_ref().map(|test| test.loss)
    }
}

fn name(features: usize, points: usize) -> String {
    format!("F{features}-N{points}")
}

/// Trains every combination that is not finished yet, and writes tables, plots and report.html. `begin` is called with each
/// combination, and whether it has to be trained.
///
/// # Errors
/// A training fails, or a file cannot be written. Finished combinations stay, and the same order resumes from there.
pub fn study(
    order: &StudyOrder,
    begin: impl Fn(usize, usize, bool),
    show: impl Fn(Stage) + Sync,
) -> Result<Vec<Cell>> {
    ensure!(
        !order.datasets.is_empty() && !order.features.is_empty() && !order.points.is_empty(),
        "a study needs a dataset, numbers of features and numbers of points"
    );
    let source = Source::open(&order.settings, &order.datasets)?;
    let code = code::digest()?;
    let mut cells = Vec::new();
    for &features in &order.features {
        for &points in &order.points {
            let mut settings = order.settings.clone();
            settings.set_features(features);
            settings.point_count = points;
            let path = order
                .output
                .join("cells")
                .join(name(features, points) + ".json");
            let id = run_id(&settings, &source)?;
            let is_same = |cell: &Cell| cell.results.run_id == id && cell.code == code;
            let finished = finished(&path)?.filter(is_same);
            begin(features, points, finished.is_none());
            cells.push(match finished {
                Some(cell) => cell,
                None => train_cell(order, settings, [features, points], &path, &show)?,
            });
        }
    }
    table::write(&order.output, &cells)?;
    let images = chart::draw_all(&order.output, &cells)?;
    html::write(&order.output, order, &cells, &images)?;
    Ok(cells)
}

fn finished(path: &Path) -> Result<Option<Cell>> {
    if !path.exists() {
        return Ok(None);
    }
    let read = || -> Result<Cell> { Ok(serde_json::from_slice(&std::fs::read(path)?)?) };
    let cell = read().with_context(|| format!("cannot read {}; delete it", path.display()))?;
    Ok(Some(cell))
}

fn train_cell(
    order: &StudyOrder,
    settings: Settings,
    [features, points]: [usize; 2],
    path: &Path,
    show: &(impl Fn(Stage) + Sync),
) -> Result<Cell> {
    let order = Order {
        settings,
        datasets: order.datasets.clone(),
        output: order.output.join("runs"),
        model: path.with_extension("onnx"),
        backend: order.backend,
        fresh: false,
    };
    let cell = Cell {
        features,
        points,
        results: run(&order, show)?,
        code: code::digest()?,
    };
    write_whole(path, &serde_json::to_vec_pretty(&cell)?)?;
    Ok(cell)
}
