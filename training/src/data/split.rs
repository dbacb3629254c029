//! Splits meshes into training, validation and test sets, without leakage between similar dents.

use std::collections::HashMap;

use anyhow::{Context, Result, ensure};
use mesh::Mesh;
use nalgebra::Vector2;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sim_dataset::digest::hex_digest;

use super::clouds::Split;
use super::mesh_dataset::{MeshDataset, MeshFile};

/// What determines the split of a dataset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SplitSettings {
    /// Seed of the random order of the dents.
    pub seed: u64,
    /// Share of the meshes in the test set, 0 to 1.
    pub test_share: f64,
    /// Share of the other meshes in the validation set, 0 to 1.
    pub validation_share: f64,
}

/// A dent regardless of rotation, mirroring and swapping of the fingers, which do not change a solid of revolution: the
/// height at which the fingers press and the angle between them about the axis, both in bins. All depths of a grasp belong to
/// one dent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Dent {
    height: i64,
    angle: i64,
}

/// Width of a height bin: the camera hardly tells dents apart that are closer together.
const HEIGHT_STEP_M: f64 = 0.002;
/// Width of an angle bin: about 10°.
const ANGLE_STEP_RAD: f64 = 0.17;

impl Dent {
    /// The dent of a mesh (+z up) pressed at these two vertices.
    fn of(mesh: &Mesh, handles: [u32; 2]) -> Option<Self> {
        let (min, max) = mesh.bounds();
        let middle = nalgebra::center(&min, &max);
        let place = |handle: u32| mesh.vertices.get(handle as usize);
        let [first, second] = [place(handles[0])?, place(handles[1])?];
        let aside =
            |place: &nalgebra::Point3<f32>| -> Vector2<f64> { (place - middle).xy().cast() };
        let height_m = f64::from(nalgebra::center(first, second).z - min.z);
        let angle_rad = aside(first).angle(&aside(second));
        Some(Self {
            height: (height_m / HEIGHT_STEP_M).floor() as i64,
            angle: (angle_rad / ANGLE_STEP_RAD).round() as i64,
        })
    }
}

/// The set of each mesh, random within each class. All meshes of one dent are in the same set, because nearly identical
/// meshes in training and test set would inflate the accuracy. The split of a class does not depend on other classes.
///
/// # Errors
/// A mesh cannot be read, or a class has fewer than three dents.
pub(crate) fn split(dataset: &MeshDataset, settings: &SplitSettings) -> Result<Vec<Split>> {
    let dents = dents(dataset)?;
    let mut split = vec![Split::Train; dataset.meshes.len()];
    for (label, name) in dataset.labels.iter().enumerate() {
        let of_class = |index: &usize| dataset.meshes[*index].label == label as u32;
        let mut meshes: Vec<usize> = (0..dataset.meshes.len()).filter(of_class).collect();
        meshes.sort_by_key(|&index| dents[index]);
        let mut groups: Vec<&[usize]> = meshes.chunk_by(|&a, &b| dents[a] == dents[b]).collect();
        ensure!(
            groups.len() >= 3,
            "{name} has too few meshes: {} of {} unlike grasps, and 3 are needed, for training, validation and test; \
             make more with generate_dataset --count",
            meshes.len(),
            groups.len()
        );
        groups.shuffle(&mut random(settings.seed, name));
        let (test, others) = cut(&groups, settings.test_share);
        let (validation, _) = cut(others, settings.validation_share);
        for (part, groups) in [(Split::Test, test), (Split::Validation, validation)] {
            for &index in groups.iter().copied().flatten() {
                split[index] = part;
            }
        }
    }
    Ok(split)
}

/// The dent of each mesh. One mesh of each grasp is read.
fn dents(dataset: &MeshDataset) -> Result<Vec<Dent>> {
    let mut first_of: HashMap<usize, &MeshFile> = HashMap::new();
    for mesh in &dataset.meshes {
        first_of.entry(mesh.grasp).or_insert(mesh);
    }
    let dent = |(grasp, file): (usize, &MeshFile)| {
        let dent = Dent::of(&file.read()?, file.handles);
        let damaged = || {
            format!(
                "{} lacks the vertices that manifest.csv names",
                file.path.display()
            )
        };
        Ok((grasp, dent.with_context(damaged)?))
    };
    let dents: Vec<Result<(usize, Dent)>> = first_of.into_par_iter().map(dent).collect();
    let dents: HashMap<usize, Dent> = dents.into_iter().collect::<Result<_>>()?;
    Ok(dataset
        .meshes
        .iter()
        .map(|mesh| dents[&mesh.grasp])
        .collect())
}

/// The random generator of one class: it depends on the seed and the class's name alone.
fn random(seed: u64, name: &str) -> Pcg64Mcg {
    let digest = hex_digest(format!("{seed} {name}").as_bytes());
    Pcg64Mcg::seed_from_u64(u64::from_str_radix(&digest[..16], 16).unwrap_or(seed))
}

/// Splits groups into a first part with this share of all members, and the rest. Each part gets at least one group.
fn cut<'a, 'b>(groups: &'b [&'a [usize]], share: f64) -> (&'b [&'a [usize]], &'b [&'a [usize]]) {
    let whole: usize = groups.iter().map(|group| group.len()).sum();
    let mut held = 0.0;
    let reaching = groups.iter().position(|group| {
        let half = group.len() as f64 / 2.0;
        held += 2.0 * half;
        held - half >= share * whole as f64
    });
    groups.split_at(reaching.unwrap_or(groups.len()).clamp(1, groups.len() - 1))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::*;

    #[test]
    fn a_dent_stays_itself_turned_mirrored_and_swapped() {
        let can = Mesh::cylinder(0.033, 0.0, 0.12, 48).subdivided();
        let wall: Vec<u32> = (0..can.vertices.len() as u32)
            .filter(|&v| (can.vertices[v as usize].z - 0.06).abs() < 1e-4)
            .collect();
        let handles = [wall[0], wall[wall.len() / 3]];
        let dent = Dent::of(&can, handles);
        assert!(dent.is_some());
        let turned = can.transformed(&Isometry3::rotation(Vector3::z() * 1.1));
        assert_eq!(Dent::of(&turned, handles), dent);
        let mut mirrored = can.clone();
        mirrored.vertices.iter_mut().for_each(|v| v.x = -v.x);
        assert_eq!(Dent::of(&mirrored, handles), dent);
        assert_eq!(Dent::of(&can, [handles[1], handles[0]]), dent);
        assert_ne!(Dent::of(&can, [wall[0], wall[wall.len() / 6]]), dent);
        let mut shifted = can.clone();
        for handle in handles {
            shifted.vertices[handle as usize].z += 0.003;
        }
        assert_ne!(Dent::of(&shifted, handles), dent);
        assert_eq!(Dent::of(&can, [0, u32::MAX]), None);
    }
}
