//! Sources of clouds: simulated scans, or the whole surfaces of meshes. Clouds are cached in files.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use classifier::ModelMetadata;
use sim_objects::ObjectClass;

use super::clouds::{LabelledClouds, Split};
use super::mesh_clouds;
use super::mesh_dataset::{MeshDataset, sorted_labels};
use super::scans::{scan, scan_to_keep};
use super::trained_on::TrainedOn;
use crate::code;
use crate::network::NetworkKind;
use crate::progress::Stage;
use crate::settings::{Settings, fingerprint};

/// Source of the clouds.
#[derive(Debug, Clone)]
pub enum Source {
    /// Simulated scans of the eight objects and of these meshes. Meshes with the name of one of the eight replace it.
    Scans(MeshDataset),
    /// Simulated scans of these meshes.
    ScansOf(MeshDataset),
    /// Points sampled from the whole surfaces of these meshes.
    Meshes(MeshDataset),
}

/// Clouds to train with.
#[derive(Debug, Clone)]
pub struct Data {
    /// Training set.
    pub train: LabelledClouds,
    /// Validation set: chooses the best epoch.
    pub validation: LabelledClouds,
    /// Test set: evaluated once, after training; only of [`Source::Meshes`].
    pub test: Option<LabelledClouds>,
    /// Clouds whose features are kept for `teach`: to fit layers with, and of other specimens to check with; not of
    /// [`Source::Meshes`].
    pub kept: Option<[LabelledClouds; 2]>,
}

impl Source {
    /// The source for the settings' network and these dataset folders.
    ///
    /// # Errors
    /// A folder is no complete dataset, or there are fewer than two objects.
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

    /// A fingerprint of settings and data, for file names.
    ///
    /// # Errors
    /// The settings cannot be written as YAML.
    pub fn fingerprint(&self, settings: &Settings) -> Result<String> {
        let (Self::Scans(dataset) | Self::ScansOf(dataset) | Self::Meshes(dataset)) = self;
        fingerprint(&(settings, &dataset.digest))
    }

    /// The entry of the model file that identifies the data.
    pub fn trained_on(&self, settings: &Settings) -> TrainedOn {
        let (Self::Scans(dataset) | Self::ScansOf(dataset) | Self::Meshes(dataset)) = self;
        TrainedOn {
            manifests: dataset.manifests.clone(),
            split: settings.split(),
        }
    }

    /// The clouds, taken from the file of an earlier run with the same settings and code if there is one.
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
        let maker = Maker {
            settings,
            metadata,
            output,
            fresh,
            show,
        };
        match self {
            Self::Scans(dataset) | Self::ScansOf(dataset) => maker.scanned(dataset),
            Self::Meshes(dataset) => maker.sampled(dataset),
        }
    }
}

/// How clouds are made, and where they are cached.
struct Maker<'a, S> {
    settings: &'a Settings,
    metadata: &'a ModelMetadata,
    output: &'a Path,
    /// Whether to ignore cached clouds.
    fresh: bool,
    show: &'a S,
}

impl<S: Fn(Stage) + Sync> Maker<'_, S> {
    /// Clouds of simulated scans.
    fn scanned(&self, dataset: &MeshDataset) -> Result<Data> {
        let (settings, metadata) = (self.settings, self.metadata);
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
            (settings.strangers, settings.near_strangers),
            settings.point_count,
            &settings.centring,
            &settings.scans,
        );
        let mut name = fingerprint(&determining)?;
        if settings.only_datasets {
            name += "-only";
        }
        let clouds = self.kept_or_made(&name, || scan(dataset, settings, metadata, self.show))?;
        let part = |split| clouds.part(split, settings.point_count);
        let kept = self.kept_or_made(&format!("{name}-kept"), || {
            scan_to_keep(dataset, settings, metadata, self.show)
        })?;
        let kept =
            [Split::Train, Split::Validation].map(|split| kept.part(split, settings.point_count));
        Ok(Data {
            train: part(Split::Train),
            validation: part(Split::Validation),
            test: None,
            kept: Some(kept),
        })
    }

    /// Clouds of the meshes' whole surfaces.
    fn sampled(&self, dataset: &MeshDataset) -> Result<Data> {
        let (settings, metadata, show) = (self.settings, self.metadata, self.show);
        let point_count = settings.point_count;
        // N is not part of the fingerprint: runs with any N up to P share one file.
        let determining = (
            settings.seed,
            &dataset.digest,
            &settings.centring,
            metadata.normals,
            &settings.meshes,
            point_count.max(settings.meshes.kept_points),
        );
        let clouds = self.kept_or_made(&fingerprint(&determining)?, || {
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
            kept: None,
        })
    }

    /// Returns the clouds in the file if this program's code made them and `fresh` is not asked for; otherwise makes them by
    /// `make` and writes the file.
    fn kept_or_made(
        &self,
        fingerprint: &str,
        make: impl FnOnce() -> Result<LabelledClouds>,
    ) -> Result<LabelledClouds> {
        let path = self
            .output
            .join(format!("dataset-{fingerprint}"))
            .join("clouds.npz");
        let code = code::digest()?;
        if !self.fresh
            && let Some(clouds) = LabelledClouds::read_own(&path, &code)?
        {
            return Ok(clouds);
        }
        let clouds = make()?;
        clouds.write(&path, &code)?;
        Ok(clouds)
    }
}
