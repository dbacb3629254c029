//! Clouds of simulated scans: to train and validate with, and to be kept for `teach`.

use adaptation::STRANGERS;
use anyhow::Result;
use classifier::ModelMetadata;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::clouds::{LabelledClouds, Split};
use super::mesh_dataset::{MeshDataset, MeshFile};
use super::simulate::simulate;
use super::specimens::Labelled;
use super::split::split;
use crate::kept;
use crate::progress::Stage;
use crate::settings::Settings;

/// Training and validation clouds of simulated scans.
pub(super) fn scan(
    dataset: &MeshDataset,
    settings: &Settings,
    metadata: &ModelMetadata,
    show: &(impl Fn(Stage) + Sync),
) -> Result<LabelledClouds> {
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    let split = split(dataset, &settings.split())?;
    let none = metadata.labels.len() as u32;
    let labelled = |each, strangers, near, part| -> Result<Vec<Labelled>> {
        let meshes = |object: &str| meshes_of(dataset, &split, object, part);
        let mut labelled = Labelled::of(&metadata.labels, each, meshes)?;
        labelled.extend(Labelled::nothing_known(none, strangers));
        if near > 0 {
            labelled.extend(Labelled::near_strangers(none, near));
        }
        Ok(labelled)
    };
    let fewer = settings.validation_specimens_per_class;
    let train = labelled(
        settings.specimens_per_class,
        settings.strangers,
        settings.near_strangers,
        Split::Train,
    )?;
    let near = fewer.min(settings.near_strangers);
    let validation = labelled(fewer, fewer, near, Split::Validation)?;
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

/// Further clouds of everything that a network of these settings knows, and of strangers.
pub(super) fn scan_to_keep(
    dataset: &MeshDataset,
    settings: &Settings,
    metadata: &ModelMetadata,
    show: &(impl Fn(Stage) + Sync),
) -> Result<LabelledClouds> {
    // Others than those of training.
    let mut random = Pcg64Mcg::seed_from_u64(!settings.seed);
    let split = split(dataset, &settings.split())?;
    let none = metadata.labels.len() as u32;
    let fit = kept::SCANS.min(settings.specimens_per_class);
    let labelled = |count: usize, part| -> Result<Vec<Labelled>> {
        let meshes = |object: &str| meshes_of(dataset, &split, object, part);
        let mut labelled = Labelled::of(&metadata.labels, count, meshes)?;
        labelled.extend(Labelled::nothing_known(none, STRANGERS * count));
        Ok(labelled)
    };
    let parts = [
        (labelled(fit, Split::Train)?, Split::Train),
        (
            labelled(fit.div_ceil(2), Split::Validation)?,
            Split::Validation,
        ),
    ];
    let specimens = parts.iter().flat_map(|(labelled, _)| labelled);
    show(Stage::Scanning {
        specimens: specimens.map(|labelled| labelled.count).sum(),
    });
    let mut clouds = LabelledClouds::new(metadata.point_count, metadata.columns());
    for (labelled, split) in &parts {
        let finished = || show(Stage::Scanned);
        let (scans, seed) = (&settings.scans, random.random());
        clouds.append(simulate(labelled, *split, scans, metadata, seed, finished)?);
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
