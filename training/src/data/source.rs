//! Where clouds come from: simulated scans, or the whole surfaces of meshes. What was made once is kept.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use classifier::ModelMetadata;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::ObjectClass;

use super::clouds::{LabelledClouds, Split};
use super::mesh_clouds;
use super::mesh_dataset::{MeshDataset, MeshFile, sorted_labels};
use super::simulate::simulate;
use super::specimens::Labelled;
use super::split::{SplitSettings, split};
use super::trained_on::TrainedOn;
use crate::code;
use crate::network::NetworkKind;
use crate::progress::Stage;
use crate::settings::{Settings, fingerprint};

/// Where clouds come from.
#[derive(Debug, Clone)]
pub enum Source {
    /// Simulated scans of the eight objects, and of these meshes, which stand in for those of the eight that have their
    /// name.
    Scans(MeshDataset),
    /// Simulated scans of these meshes.
    ScansOf(MeshDataset),
    /// Meshes, seen from all sides.
    Meshes(MeshDataset),
}

/// Clouds to train with.
#[derive(Debug, Clone)]
pub struct Data {
    /// Learned from.
    pub train: LabelledClouds,
    /// Choose the best epoch.
    pub validation: LabelledClouds,
    /// Seen only when all is decided.
    pub test: Option<LabelledClouds>,
}

impl Source {
    /// What this network learns from.
    ///
    /// # Errors
    /// A folder is no whole dataset, or there are less than two objects.
    pub fn open(settings: &Settings, datasets: &[PathBuf]) -> Result<Self> {
        let dataset = MeshDataset::open(datasets)?;
        let network = settings.network;
        match dataset.labels.as_slice() {
            _ if network == NetworkKind::Robot && !settings.only_datasets => {
                Ok(Self::Scans(dataset))
            }
            [] => bail!("there are no meshes to learn from; give --dataset"),
            [only] => bail!(
                "the dataset holds {only} alone; there is nothing to tell apart: add objects, or another --dataset"
            ),
            _ if network == NetworkKind::Robot => Ok(Self::ScansOf(dataset)),
            _ => Ok(Self::Meshes(dataset)),
        }
    }

    /// Names of the classes.
    pub fn labels(&self) -> Vec<String> {
        match self {
            Self::Scans(dataset) => {
                let own = ObjectClass::ALL.iter().map(|class| class.name());
                sorted_labels(own.chain(dataset.labels.iter().map(String::as_str)))
            }
            Self::ScansOf(dataset) | Self::Meshes(dataset) => dataset.labels.clone(),
        }
    }

    /// A name for settings and data.
    ///
    /// # Errors
    /// The settings have no text.
    pub fn fingerprint(&self, settings: &Settings) -> Result<String> {
        let (Self::Scans(dataset) | Self::ScansOf(dataset) | Self::Meshes(dataset)) = self;
        fingerprint(&(settings, &dataset.digest))
    }

    /// What the model file is to say of the data.
    pub fn trained_on(&self, settings: &Settings) -> TrainedOn {
        let (Self::Scans(dataset) | Self::ScansOf(dataset) | Self::Meshes(dataset)) = self;
        TrainedOn {
            manifests: dataset.manifests.clone(),
            split: SplitSettings::of(settings),
        }
    }

    /// The clouds, from the file of an earlier run with the same settings where there is one.
    ///
    /// # Errors
    /// They cannot be made, written or read.
    pub fn data(
        &self,
        settings: &Settings,
        metadata: &ModelMetadata,
        output: &Path,
        fresh: bool,
        show: &(impl Fn(Stage) + Sync),
    ) -> Result<Data> {
        match self {
            Self::Scans(dataset) | Self::ScansOf(dataset) => {
                scanned(dataset, settings, metadata, output, fresh, show)
            }
            Self::Meshes(dataset) => sampled(dataset, settings, metadata, output, fresh, show),
        }
    }
}

fn scanned(
    dataset: &MeshDataset,
    settings: &Settings,
    metadata: &ModelMetadata,
    output: &Path,
    fresh: bool,
    show: &(impl Fn(Stage) + Sync),
) -> Result<Data> {
    ensure!(
        !metadata.normals,
        "only the paper's network takes normals; give --network paper"
    );
    let determining = (
        settings.seed,
        &dataset.digest,
        &settings.meshes,
        settings.specimens_per_class,
        settings.validation_specimens_per_class,
        settings.strangers,
        settings.point_count,
        &settings.centring,
        &settings.scans,
    );
    let mut name = fingerprint(&determining)?;
    if settings.only_datasets {
        name += "-only";
    }
    let path = clouds_file(output, &name);
    let clouds = kept_or_made(&path, fresh, || scan(dataset, settings, metadata, show))?;
    Ok(Data {
        train: clouds.part(Split::Train, settings.point_count),
        validation: clouds.part(Split::Validation, settings.point_count),
        test: None,
    })
}

/// Clouds to learn from, and to choose the best epoch by.
fn scan(
    dataset: &MeshDataset,
    settings: &Settings,
    metadata: &ModelMetadata,
    show: &(impl Fn(Stage) + Sync),
) -> Result<LabelledClouds> {
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    let split = split(dataset, &SplitSettings::of(settings))?;
    let none = metadata.labels.len() as u32;
    let labelled = |each, strangers, part| -> Result<Vec<Labelled>> {
        let meshes = |object: &str| meshes_of(dataset, &split, object, part);
        let mut labelled = Labelled::of(&metadata.labels, each, meshes)?;
        labelled.extend(Labelled::nothing_known(none, strangers));
        Ok(labelled)
    };
    let fewer = settings.validation_specimens_per_class;
    let train = labelled(
        settings.specimens_per_class,
        settings.strangers,
        Split::Train,
    )?;
    let validation = labelled(fewer, fewer, Split::Validation)?;
    let specimens = train
        .iter()
        .chain(&validation)
        .map(|labelled| labelled.count);
    show(Stage::Scanning {
        specimens: specimens.sum(),
    });
    let mut clouds = LabelledClouds::new(metadata.point_count, metadata.columns());
    for (labelled, split) in [(&train, Split::Train), (&validation, Split::Validation)] {
        let finished = || show(Stage::Scanned);
        let (scans, seed) = (&settings.scans, random.random());
        clouds.append(simulate(labelled, split, scans, metadata, seed, finished)?);
    }
    Ok(clouds)
}

/// The meshes of an object in one part of the split.
fn meshes_of(dataset: &MeshDataset, split: &[Split], object: &str, part: Split) -> Vec<MeshFile> {
    let label = dataset.labels.iter().position(|label| label == object);
    let is_wanted =
        |mesh: &MeshFile, split: Split| Some(mesh.label as usize) == label && split == part;
    let pairs = dataset.meshes.iter().zip(split);
    let wanted = pairs.filter(|(mesh, split)| is_wanted(mesh, **split));
    wanted.map(|(mesh, _)| mesh.clone()).collect()
}

fn sampled(
    dataset: &MeshDataset,
    settings: &Settings,
    metadata: &ModelMetadata,
    output: &Path,
    fresh: bool,
    show: &(impl Fn(Stage) + Sync),
) -> Result<Data> {
    let point_count = settings.point_count;
    // N itself does not matter: all N up to P look at the same file.
    let determining = (
        settings.seed,
        &dataset.digest,
        &settings.centring,
        metadata.normals,
        &settings.meshes,
        point_count.max(settings.meshes.kept_points),
    );
    let path = clouds_file(output, &fingerprint(&determining)?);
    let clouds = kept_or_made(&path, fresh, || {
        show(Stage::Sampling {
            meshes: dataset.meshes.len(),
        });
        let finished = || show(Stage::Scanned);
        let (sampling, seed) = (&settings.meshes, settings.seed);
        mesh_clouds::sample(dataset, sampling, metadata, seed, finished)
    })?;
    let part = |split| clouds.part(split, point_count);
    Ok(Data {
        train: part(Split::Train),
        validation: part(Split::Validation),
        test: Some(part(Split::Test)),
    })
}

/// The clouds in the file, if this very code made them and they are not wanted fresh; else those that `make` gives, which
/// are kept there.
fn kept_or_made(
    path: &Path,
    fresh: bool,
    make: impl FnOnce() -> Result<LabelledClouds>,
) -> Result<LabelledClouds> {
    let code = code::digest()?;
    if !fresh && let Some(clouds) = LabelledClouds::read_own(path, &code)? {
        return Ok(clouds);
    }
    let clouds = make()?;
    clouds.write(path, &code)?;
    Ok(clouds)
}

fn clouds_file(output: &Path, fingerprint: &str) -> PathBuf {
    output
        .join(format!("dataset-{fingerprint}"))
        .join("clouds.npz")
}
