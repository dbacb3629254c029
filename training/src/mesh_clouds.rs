//! Labelled clouds of a dataset of meshes, each seen from all sides, and as a file that numpy opens.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor};
use classifier::{ModelMetadata, preprocess};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::batch::Part;
use crate::mesh_dataset::{MeshDataset, MeshFile};
use crate::mesh_split::split;

pub use crate::mesh_split::Split;

/// How meshes become clouds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MeshSampling {
    /// Points spread over the surface, uniformly by area, of which the node's preprocessing chooses.
    pub surface_points: usize,
    /// P, points of a cloud that are kept; the network sees the first N. At least N, else N.
    pub kept_points: usize,
    /// Share of the meshes that are only tested on (paper, Sec. VI-B.1).
    pub test_share: f64,
    /// Share of the others that choose the best epoch.
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

/// Clouds of P points each, in the order of farthest-point sampling: the first N are what the node would choose.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshClouds {
    /// P.
    pub point_count: usize,
    /// `[M, P, 3]` in metres, the box around the object centred at the origin, up along z.
    pub points: Vec<f32>,
    /// `[M, P, 3]` of unit length, if they were asked for.
    pub normals: Option<Vec<f32>>,
    /// `[M]` class indices.
    pub labels: Vec<u32>,
    /// `[M]` numbers of [`Split`].
    pub split: Vec<u32>,
}

impl MeshClouds {
    /// Samples all meshes on all cores, as `metadata` says, but with P points. `finished` is called after each mesh.
    /// The same arguments give the same clouds.
    ///
    /// # Errors
    /// A mesh cannot be read, or a class has too few to be split.
    pub fn sample(
        dataset: &MeshDataset,
        sampling: &MeshSampling,
        metadata: &ModelMetadata,
        seed: u64,
        finished: impl Fn() + Sync,
    ) -> Result<Self> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (test, validation) = (sampling.test_share, sampling.validation_share);
        let split = split(dataset, test, validation, &mut random)?;
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
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        for input in inputs {
            let input = input?;
            let (coordinates, directions) = input.split_at(3 * point_count);
            points.extend(rows(coordinates, metadata.metres_per_unit as f32));
            normals.extend(rows(directions, 1.0));
        }
        Ok(Self {
            point_count,
            points,
            normals: metadata.normals.then_some(normals),
            labels: dataset.meshes.iter().map(|mesh| mesh.label).collect(),
            split,
        })
    }

    /// The clouds of one split, each of its first `point_count` points.
    pub fn part(&self, split: Split, point_count: usize) -> Part {
        let stride = 3 * self.point_count;
        let wanted = |index: &usize| self.split[*index] == split as u32;
        let chosen: Vec<usize> = (0..self.labels.len()).filter(wanted).collect();
        let mut values = Vec::new();
        for start in chosen.iter().map(|index| index * stride) {
            for point in (start..start + 3 * point_count).step_by(3) {
                values.extend_from_slice(&self.points[point..point + 3]);
                if let Some(normals) = &self.normals {
                    values.extend_from_slice(&normals[point..point + 3]);
                }
            }
        }
        Part {
            point_count,
            columns: if self.normals.is_some() { 6 } else { 3 },
            values,
            labels: chosen.iter().map(|&index| self.labels[index]).collect(),
        }
    }

    /// Writes an npz file: `points` float32 `[M, P, 3]` in metres, `labels` and `split` (0 training, 1 validation,
    /// 2 test) uint32 `[M]`, and `normals` as `points` if there are any.
    ///
    /// # Errors
    /// The file cannot be written; then nothing of it is left.
    pub fn write(&self, path: &Path) -> Result<()> {
        let count = self.labels.len();
        let device = &Device::Cpu;
        let array =
            |values: &[f32]| Tensor::from_slice(values, (count, self.point_count, 3), device);
        let mut arrays = vec![
            ("points", array(&self.points)?),
            ("labels", Tensor::from_slice(&self.labels, count, device)?),
            ("split", Tensor::from_slice(&self.split, count, device)?),
        ];
        if let Some(normals) = &self.normals {
            arrays.push(("normals", array(normals)?));
        }
        let folder = path.parent().context("a dataset file needs a folder")?;
        let unfinished = path.with_extension("npz.unfinished");
        let write = || -> Result<()> {
            std::fs::create_dir_all(folder)?;
            Tensor::write_npz(&arrays, &unfinished)?;
            Ok(std::fs::rename(&unfinished, path)?)
        };
        write()
            .inspect_err(|_| drop(std::fs::remove_file(&unfinished)))
            .with_context(|| format!("cannot write {}", path.display()))
    }

    /// Reads what [`MeshClouds::write`] wrote.
    ///
    /// # Errors
    /// The file cannot be read, or is not such a file.
    pub fn read(path: &Path) -> Result<Self> {
        let read = || -> Result<Self> {
            let arrays = Tensor::read_npz(path)?;
            let find = |name: &str| arrays.iter().find(|(found, _)| found == name);
            let get = |name: &str| find(name).map(|(_, array)| array);
            let points = get("points").context("it has no points")?;
            let (count, point_count, columns) = points.dims3()?;
            ensure!(columns == 3, "points have {columns} coordinates");
            let column = |name: &str| -> Result<Vec<u32>> {
                let values = get(name).with_context(|| format!("it has no {name}"))?;
                let values = values.to_vec1::<u32>()?;
                ensure!(
                    values.len() == count,
                    "{} {name} of {count} clouds",
                    values.len()
                );
                Ok(values)
            };
            let normals = get("normals").map(|normals| normals.flatten_all()?.to_vec1());
            Ok(Self {
                point_count,
                points: points.flatten_all()?.to_vec1()?,
                normals: normals.transpose()?,
                labels: column("labels")?,
                split: column("split")?,
            })
        };
        read().with_context(|| {
            format!(
                "cannot read the clouds {}; --fresh makes them again",
                path.display()
            )
        })
    }
}

/// `[3, P]` to `[P, 3]`, scaled.
fn rows(columns: &[f32], scale: f32) -> impl Iterator<Item = f32> {
    let count = columns.len() / 3;
    (0..count).flat_map(move |point| [0, 1, 2].map(|axis| scale * columns[axis * count + point]))
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
