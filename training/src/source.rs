//! Where clouds come from: simulated scans, or datasets of meshes. What was made once is kept.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use classifier::ModelMetadata;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::ObjectClass;

use crate::batch::Part;
use crate::dataset::simulate;
use crate::mesh_clouds::{MeshClouds, Split};
use crate::mesh_dataset::MeshDataset;
use crate::run::Stage;
use crate::samples::{read_npz, write_npz};
use crate::settings::{Settings, fingerprint};
use crate::specimens::Labelled;

/// Where clouds come from.
#[derive(Debug, Clone)]
pub enum Source {
    /// Simulated scans of the eight objects.
    Scans,
    /// Meshes, seen from all sides.
    Meshes(MeshDataset),
}

/// Clouds to train with.
#[derive(Debug, Clone)]
pub struct Data {
    /// Learned from.
    pub train: Part,
    /// Choose the best epoch.
    pub validation: Part,
    /// Seen only when all is decided.
    pub test: Option<Part>,
}

impl Source {
    /// These dataset folders, or scans if there are none.
    ///
    /// # Errors
    /// A folder is no whole dataset.
    pub fn open(datasets: &[PathBuf]) -> Result<Self> {
        match datasets {
            [] => Ok(Self::Scans),
            folders => MeshDataset::open(folders).map(Self::Meshes),
        }
    }

    /// Names of the classes.
    pub fn labels(&self) -> Vec<String> {
        match self {
            Self::Scans => ObjectClass::ALL
                .map(|class| class.name().to_owned())
                .to_vec(),
            Self::Meshes(dataset) => dataset.labels.clone(),
        }
    }

    /// A name for settings and data.
    ///
    /// # Errors
    /// The settings have no text.
    pub fn fingerprint(&self, settings: &Settings) -> Result<String> {
        match self {
            Self::Scans => fingerprint(settings),
            Self::Meshes(dataset) => fingerprint(&(settings, &dataset.digest)),
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
            Self::Scans => scanned(settings, metadata, output, fresh, show),
            Self::Meshes(dataset) => sampled(dataset, settings, metadata, output, fresh, show),
        }
    }
}

fn scanned(
    settings: &Settings,
    metadata: &ModelMetadata,
    output: &Path,
    fresh: bool,
    show: &(impl Fn(Stage) + Sync),
) -> Result<Data> {
    ensure!(
        !metadata.normals,
        "normals are only made of meshes; give --dataset"
    );
    let counts = [
        settings.specimens_per_class,
        settings.validation_specimens_per_class,
    ];
    let determining = (
        settings.seed,
        counts,
        settings.strangers,
        settings.point_count,
        &settings.centring,
        &settings.scans,
    );
    let path = clouds_file(output, &fingerprint(&determining)?);
    let (train, validation) = if path.is_file() && !fresh {
        read_npz(&path)?
    } else {
        let strangers_label = metadata.labels.len() as u32;
        let parts = [(counts[0], settings.strangers), (counts[1], counts[1])];
        let parts = parts.map(|(each, strangers)| {
            let mut labelled = Labelled::classes(each);
            labelled.push(Labelled::random_solids(strangers_label, strangers));
            labelled
        });
        let specimens = parts.iter().flatten().map(|labelled| labelled.count).sum();
        show(Stage::Scanning { specimens });
        let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
        let mut part = |labelled: &[Labelled]| {
            let finished = || show(Stage::Scanned);
            simulate(
                labelled,
                &settings.scans,
                metadata,
                random.random(),
                finished,
            )
        };
        let (train, validation) = (part(&parts[0])?, part(&parts[1])?);
        write_npz(&path, &train, &validation)?;
        (train, validation)
    };
    Ok(Data {
        train: train.into(),
        validation: validation.into(),
        test: None,
    })
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
    let clouds = if path.is_file() && !fresh {
        MeshClouds::read(&path)?
    } else {
        show(Stage::Sampling {
            meshes: dataset.meshes.len(),
        });
        let finished = || show(Stage::Scanned);
        let (sampling, seed) = (&settings.meshes, settings.seed);
        let clouds = MeshClouds::sample(dataset, sampling, metadata, seed, finished)?;
        clouds.write(&path)?;
        clouds
    };
    let part = |split| clouds.part(split, point_count);
    Ok(Data {
        train: part(Split::Train),
        validation: part(Split::Validation),
        test: Some(part(Split::Test)),
    })
}

fn clouds_file(output: &Path, fingerprint: &str) -> PathBuf {
    output
        .join(format!("dataset-{fingerprint}"))
        .join("clouds.npz")
}
