//! Labelled clouds of a dataset of meshes, each seen from all sides.

use anyhow::{Context, Result};
use classifier::{ModelMetadata, preprocess};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::clouds::{LabelledClouds, Seen};
use super::mesh_dataset::{MeshDataset, MeshFile};
use super::split::{SplitSettings, split};

/// How meshes become clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeshSampling {
    /// Points sampled uniformly by area from the surface; the node's preprocessing chooses among them.
    pub surface_points: usize,
    /// P, points of a cloud that are kept in the file; the network sees the first N. Values below N count as N.
    pub kept_points: usize,
    /// Share of the meshes in the test set (paper, Sec. VI-B.1); 0 to 1.
    pub test_share: f64,
    /// Share of the other meshes in the validation set; 0 to 1.
    pub validation_share: f64,
}

impl Default for MeshSampling {
    fn default() -> Self {
        Self {
            surface_points: 2048,
            kept_points: 512,
            test_share: 0.3,
            validation_share: 0.1,
        }
    }
}

/// Clouds of all meshes, made on all cores as `metadata` says, but with P points. `finished` is called after each mesh. The
/// same arguments give the same clouds.
///
/// # Errors
/// A mesh cannot be read, or a class has too few to be split.
pub fn sample(
    dataset: &MeshDataset,
    sampling: &MeshSampling,
    metadata: &ModelMetadata,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<LabelledClouds> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let split = split(
        dataset,
        &SplitSettings {
            seed,
            test_share: sampling.test_share,
            validation_share: sampling.validation_share,
        },
    )?;
    let point_count = sampling.kept_points.max(metadata.point_count);
    let surface_points = sampling.surface_points.max(point_count);
    let metadata = ModelMetadata {
        point_count,
        ..metadata.clone()
    };
    let meshes: Vec<(&MeshFile, u64)> = dataset
        .meshes
        .iter()
        .map(|mesh| (mesh, random.random()))
        .collect();
    let inputs: Vec<Result<Vec<f32>>> = meshes
        .into_par_iter()
        .map(|(mesh, seed)| {
            let input = input(mesh, surface_points, &metadata, seed);
            finished();
            input
        })
        .collect();
    let mut clouds = LabelledClouds::new(point_count, metadata.columns());
    for ((input, mesh), split) in inputs.into_iter().zip(&dataset.meshes).zip(split) {
        let seen = Seen {
            label: mesh.label,
            view_count: 0,
            held: false,
            taken: input?,
        };
        clouds.push(&seen, metadata.metres_per_unit, split);
    }
    Ok(clouds)
}

/// The network's input of one mesh, as the node would make it of its surface.
fn input(
    mesh: &MeshFile,
    surface_points: usize,
    metadata: &ModelMetadata,
    seed: u64,
) -> Result<Vec<f32>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let surface = mesh.read()?.surface_points(surface_points, &mut random);
    let up = Vector3::z();
    preprocess(&surface, &up, metadata)
        .with_context(|| format!("{} has no usable surface", mesh.path.display()))
}
