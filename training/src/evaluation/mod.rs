//! How good a model file is on clouds that it was not trained on.

pub(crate) mod answers;
mod by_view;
pub mod calibration;
pub mod confusion;
mod known;
mod test_result;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use classifier::{Model, ModelMetadata, Output, preprocess_parts};
use serde::Serialize;

pub use by_view::DataTest;
pub use known::Known;
pub use test_result::TestResult;

use crate::data::clouds::Seen;
use crate::data::mesh_dataset::{MeshDataset, MeshFile};
use crate::data::simulate::see_all;
use crate::data::specimens::{Labelled, Specimens};
use crate::data::trained_on::{Unseen, unseen};
use sim_scan::{ScanParameters, ScannedObject};

/// Result of evaluating a model.
#[derive(Debug, Clone, Serialize)]
pub struct Evaluation {
    /// The training run that made the model.
    pub model_id: String,
    /// Name and version of the network.
    pub network: String,
    /// The inference provider that ran it: `openvino` or `cpu`.
    pub provider: String,
    /// Answers on clouds of the model's classes.
    pub tests: Vec<DataTest>,
    /// How well strangers are told from them.
    pub known: Known,
    /// Which of the dataset's meshes were measured on; `None` without a dataset.
    pub of_dataset: Option<Unseen>,
}

/// What to evaluate a model on.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Number of specimens of each of the eight objects, of each object of the dataset, and of each stranger.
    pub specimens: NonZeroUsize,
    /// A folder that generate_dataset made.
    pub dataset: Option<PathBuf>,
    /// Random variation of the scans.
    pub scans: ScanParameters,
    /// Seed of all random choices.
    pub seed: u64,
}

/// Evaluates a model on simulated scans.
///
/// # Errors
/// The dataset has objects that the model does not know, or a scan or the network fails.
pub fn evaluate(
    model: &mut Model,
    settings: &Settings,
    finished: impl Fn() + Sync,
) -> Result<Evaluation> {
    let metadata = model.metadata().clone();
    let (count, seed) = (settings.specimens.get(), settings.seed);
    let take =
        |object: &ScannedObject| preprocess_parts(&object.points, &object.up, &metadata).ok();
    let mut measure = |labelled: &[Labelled]| -> Result<Vec<Seen<Output>>> {
        let seen = see_all(labelled, &settings.scans, seed, take, &finished)?;
        let answer = |seen: Seen<Vec<f32>>| Ok(seen.with(model.infer(&seen.taken)?));
        seen.into_iter().map(answer).collect()
    };
    let scores = |answers: &[Seen<Output>]| {
        let answers = answers.iter();
        let judged = answers.map(|answer| &answer.taken).map(|output| {
            let probability = calibration::highest_probability(&output.log_probabilities);
            (output.known_score, probability)
        });
        judged.collect::<Vec<_>>()
    };
    let mut tests = Vec::new();
    let mut of_dataset = None;

    let own = own_classes(&metadata.labels, count);
    let mut known_scores = Vec::new();
    if !own.is_empty() {
        let answers = measure(&own)?;
        let data = format!("parametric objects, {count} specimens a class, seed {seed}");
        tests.extend(by_view::by_view(&data, &metadata, &answers));
        known_scores = scores(&answers);
    } else if settings.dataset.is_none() {
        let known = metadata.labels.join(", ");
        bail!(
            "the model knows none of the eight objects, but {known}; give --dataset with some of these"
        );
    }
    if let Some(folder) = &settings.dataset {
        let (classes, unseen) = dataset_classes(folder, &metadata, count)?;
        let answers = measure(&classes)?;
        let data = format!(
            "{}, {count} meshes a class{}",
            folder.display(),
            said_of(unseen)
        );
        of_dataset = Some(unseen);
        tests.extend(by_view::by_view(&data, &metadata, &answers));
        if own.is_empty() {
            known_scores = scores(&answers);
        }
    }
    let strangers = measure(&Labelled::strangers(metadata.labels.len() as u32, count))?;
    let known = Known::of(&known_scores, &scores(&strangers), metadata.known_threshold);
    Ok(Evaluation {
        model_id: metadata.run_id.clone(),
        network: metadata.network_version.clone(),
        provider: model.provider().to_owned(),
        tests,
        known,
        of_dataset,
    })
}

/// How a test's name describes the dataset's meshes.
fn said_of(unseen: Unseen) -> &'static str {
    match unseen {
        Unseen::All => "",
        Unseen::HeldOut => " of those held out in training",
        Unseen::Unknown => ", perhaps trained on",
    }
}

/// The repository's own objects that the model knows.
fn own_classes(labels: &[String], count: usize) -> Vec<Labelled> {
    let known = labels.iter().enumerate().filter_map(|(label, name)| {
        let class = name.parse().ok()?;
        Some(Labelled {
            label: label as u32,
            specimens: Specimens::Class(class),
            count,
        })
    });
    known.collect()
}

/// The objects of a dataset, without the meshes that the model's file says it was trained on. Each must be one of the
/// model's labels.
fn dataset_classes(
    folder: &Path,
    metadata: &ModelMetadata,
    count: usize,
) -> Result<(Vec<Labelled>, Unseen)> {
    let labels = &metadata.labels;
    let dataset = MeshDataset::open(&[folder.to_path_buf()])?;
    let (meshes, unseen) = unseen(&dataset, metadata.trained_on.as_deref())?;
    let unknown = dataset.labels.iter().find(|name| !labels.contains(name));
    if let Some(name) = unknown {
        let (folder, known) = (folder.display(), labels.join(", "));
        bail!("{folder} holds {name}, which the model does not know; it knows {known}");
    }
    let mut classes = Labelled::of(&dataset.labels, count, |object| {
        let of_object = |mesh: &&MeshFile| dataset.labels[mesh.label as usize] == object;
        meshes.iter().filter(of_object).cloned().collect()
    })?;
    for class in &mut classes {
        let name = &dataset.labels[class.label as usize];
        class.label = labels.iter().position(|label| label == name).unwrap_or(0) as u32;
    }
    Ok((classes, unseen))
}

impl Evaluation {
    /// A few lines a test, for people.
    pub fn to_text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let mut text = String::new();
        for DataTest { data, test } in &self.tests {
            text += &format!(
                "{}\n{}accuracy {} on {} clouds; called known: {}, and wrong: {}; calibration error {:.3}\n\n",
                data,
                test.confusion.table(),
                percent(test.accuracy),
                test.clouds,
                percent(test.known_share),
                percent(test.known_wrong_share),
                test.calibration_error,
            );
        }
        let known = &self.known;
        text + &format!(
            "strangers: AUROC {:.3} ({} known clouds against {}); called known: {} of the known, {} of the strangers\n\
             {}; model {} ({}), {}\n",
            known.auroc,
            known.known_clouds,
            known.stranger_clouds,
            percent(known.known_called_known),
            percent(1.0 - known.strangers_called_unknown),
            match self.of_dataset {
                Some(Unseen::Unknown) =>
                    "the model file does not say whether the dataset's meshes were trained on",
                _ => "none of it was trained on",
            },
            self.model_id,
            self.network,
            self.provider,
        )
    }
}
