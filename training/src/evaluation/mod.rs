//! How good a model file is on clouds that it was not trained on.

pub(crate) mod answers;
mod by_view;
pub mod confusion;
pub mod figures;
mod known;
mod origin;
pub mod real;
mod seeds;
pub mod shift;
mod test_result;
mod text;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use classifier::{Model, ModelMetadata, Output, preprocess_parts};
use serde::{Deserialize, Serialize};
use sim_objects::{Difference, Instances, ObjectClass};

pub use adaptation::calibration;
pub use by_view::{DataTest, Objects};
pub use known::Known;
pub use origin::Origin;
pub use seeds::{KnownRow, KnownShares, StrangerRow, StrangerShares, Tests};
pub use shift::Shifts;
pub use test_result::TestResult;

use origin::Digest;

use crate::data::clouds::Seen;
use crate::data::mesh_dataset::{MeshDataset, MeshFile};
use crate::data::simulate::see_all;
use crate::data::specimens::{Labelled, Specimens};
use crate::data::trained_on::{Unseen, unseen};
use sim_scan::{ScanParameters, ScannedObject};

/// Result of evaluating a model.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Evaluation {
    /// What was measured on what.
    #[serde(flatten)]
    pub origin: Origin,
    /// Answers on clouds of the model's classes.
    pub tests: Vec<DataTest>,
    /// How well strangers of other kinds and sizes are told from them.
    pub known: Known,
    /// The same of objects of the eight's kinds, by how nearly they have their sizes; nearest first.
    pub near: Vec<KnownNear>,
    /// Which of the dataset's meshes were measured on; `None` without a dataset.
    pub of_dataset: Option<Unseen>,
}

/// How well near strangers are told from known objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownNear {
    /// How far their sizes are from those of the eight.
    pub difference: String,
    /// The result.
    #[serde(flatten)]
    pub known: Known,
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
    let mut digest = Digest::default();
    let scans = &settings.scans;
    let mut measure =
        |labelled: &[Labelled], scans: &ScanParameters| -> Result<Vec<Seen<Output>>> {
            let seen = see_all(labelled, scans, seed, take, &finished)?;
            seen.iter().for_each(|seen| digest.add(&seen.taken));
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

    let own =
        |specimens: fn(ObjectClass) -> Specimens| own_classes(&metadata.labels, count, specimens);
    let held_out = own(|class| Specimens::Family(class, Instances::Test));
    let mut known_scores = Vec::new();
    if !held_out.is_empty() {
        let mut tested = |what: &str, are: Objects, answers: &[Seen<Output>]| {
            tests.extend(by_view::by_view(what, are, &metadata, answers));
        };
        let answers = measure(&held_out, scans)?;
        tested(HELD_OUT, Objects::OthersOfTheKind, &answers);
        known_scores = scores(&answers);
        let answers = measure(&own(Specimens::Traced), scans)?;
        tested(TRACED, Objects::Same, &answers);
        let balls = SMALL_BALLS.map(ObjectClass::name);
        let is_ball = |seen: &Seen<Output>| {
            let label = metadata.labels.get(seen.label as usize);
            label.is_some_and(|label| balls.contains(&label.as_str()))
        };
        let of_balls: Vec<_> = answers.into_iter().filter(is_ball).collect();
        tested(TRACED_BALLS, Objects::Same, &of_balls);
        // The same specimens, poses and noise as the held-out instances.
        let mut flank = measure(&held_out, &flank_lost(scans))?;
        flank.retain(|seen| seen.view_count > 0);
        tested(FLANK_LOST, Objects::OthersOfTheKind, &flank);
    } else if settings.dataset.is_none() {
        let known = metadata.labels.join(", ");
        bail!(
            "the model knows none of the eight objects, but {known}; give --dataset with some of these"
        );
    }
    if let Some(folder) = &settings.dataset {
        let (classes, unseen) = dataset_classes(folder, &metadata, count)?;
        let answers = measure(&classes, scans)?;
        let name = folder.file_name().unwrap_or(folder.as_os_str());
        let data = format!("meshes of {}{}", name.display(), said_of(unseen));
        of_dataset = Some(unseen);
        let are = Objects::OfDataset;
        tests.extend(by_view::by_view(&data, are, &metadata, &answers));
        if held_out.is_empty() {
            known_scores = scores(&answers);
        }
    }
    let none = metadata.labels.len() as u32;
    let mut against_known = |strangers: &[Labelled]| -> Result<Known> {
        let strangers = scores(&measure(strangers, scans)?);
        Ok(Known::of(
            &known_scores,
            &strangers,
            metadata.known_threshold,
        ))
    };
    let known = against_known(&Labelled::strangers(none, count))?;
    let near = Difference::ALL.map(|difference| -> Result<KnownNear> {
        let strangers = Labelled {
            label: none,
            specimens: Specimens::NearStranger(difference, Instances::Test),
            count: NEAR_STRANGERS * count,
        };
        Ok(KnownNear {
            difference: difference.to_string(),
            known: against_known(&[strangers])?,
        })
    });
    let near = near.into_iter().collect::<Result<Vec<_>>>()?;
    Ok(Evaluation {
        origin: Origin::of(model, settings.specimens, seed, digest),
        tests,
        known,
        near,
        of_dataset,
    })
}

/// Objects of the families that the model was not trained on.
const HELD_OUT: &str = "held-out instances of the families";
/// Objects whose outlines were traced from scans; half of the training specimens are such.
const TRACED: &str = "the traced objects";
/// Those of [`SMALL_BALLS`] among them.
const TRACED_BALLS: &str = "of these, tiny-ball and small-ball";
/// Held-out instances of which less is seen than ever in training.
const FLANK_LOST: &str = "held-out instances, 6 mm of one side not seen";
/// The two that differ least.
const SMALL_BALLS: [ObjectClass; 2] = [ObjectClass::TinyBall, ObjectClass::SmallBall];

/// Scans in which one side of the object is not seen, 6 mm wide.
fn flank_lost(scans: &ScanParameters) -> ScanParameters {
    ScanParameters {
        flank_lost_share: 1.0,
        flank_lost_m: [0.006; 2],
        ..scans.clone()
    }
}

/// Number of near strangers of each difference in size, by specimens of a class.
const NEAR_STRANGERS: usize = 4;

/// How a test's name describes the dataset's meshes.
fn said_of(unseen: Unseen) -> &'static str {
    match unseen {
        Unseen::All => "",
        Unseen::HeldOut => ", those held out in training",
        Unseen::Unknown => ", perhaps trained on",
    }
}

/// Those of the eight that the model knows.
fn own_classes(
    labels: &[String],
    count: usize,
    specimens: impl Fn(ObjectClass) -> Specimens,
) -> Vec<Labelled> {
    let known = labels.iter().enumerate().filter_map(|(label, name)| {
        let class = name.parse().ok()?;
        Some(Labelled {
            label: label as u32,
            specimens: specimens(class),
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
