//! Specimens: the single objects that are scanned.

use anyhow::{Context, Result};
use mesh::Mesh;
use rand::Rng;
use rand::seq::IndexedRandom;
use sim_objects::{Difference, Instances, NearStranger, ObjectClass, Stranger, random_solid};
use sim_scan::{ScanParameters, dented_of_size};

use super::mesh_dataset::MeshFile;

/// Where the specimens of one label come from.
#[derive(Debug, Clone)]
pub enum Specimens {
    /// One of the eight objects; each specimen has a new random dent.
    Class(ObjectClass),
    /// Dented meshes of a dataset, +z up; each specimen is a random one of them.
    Meshes(Vec<MeshFile>),
    /// An object that is none of the classes.
    Stranger(Stranger),
    /// Dented objects of the eight's kinds and nearly their sizes.
    NearStranger(Difference, Instances),
    /// Random solids that are none of the eight objects.
    RandomSolids,
    /// No object. If the camera mount is badly known, the crop leaves points of the gripper.
    EmptyHand,
}

/// Specimens of one label.
#[derive(Debug, Clone)]
pub struct Labelled {
    /// Index of the class; the number of classes stands for "none of them".
    pub label: u32,
    /// Source of the specimens.
    pub specimens: Specimens,
    /// Number of specimens.
    pub count: usize,
}

impl Labelled {
    /// The same number of specimens of each label: meshes if there are any of that name, otherwise one of the eight objects.
    ///
    /// # Errors
    /// A label that has neither.
    pub fn of(
        labels: &[String],
        count: usize,
        meshes: impl Fn(&str) -> Vec<MeshFile>,
    ) -> Result<Vec<Self>> {
        let labelled = |(label, name): (usize, &String)| {
            let meshes = meshes(name);
            let specimens = if meshes.is_empty() {
                Specimens::Class(name.parse()?)
            } else {
                Specimens::Meshes(meshes)
            };
            Ok(Self {
                label: label as u32,
                specimens,
                count,
            })
        };
        labels.iter().enumerate().map(labelled).collect()
    }

    /// Training specimens of "none of the classes": `count` random solids, and a fifth as many empty hands. `label` is the
    /// number of classes.
    pub fn nothing_known(label: u32, count: usize) -> [Self; 2] {
        let of = |specimens, count| Self {
            label,
            specimens,
            count,
        };
        [
            of(Specimens::RandomSolids, count),
            of(Specimens::EmptyHand, count / 5),
        ]
    }

    /// Specimens of "none of the classes" that are like one of them: `count` in all, in equal parts of each difference in size.
    pub fn near_strangers(label: u32, count: usize, instances: Instances) -> [Self; 3] {
        Difference::ALL.map(|difference| Self {
            label,
            specimens: Specimens::NearStranger(difference, instances),
            count: count / Difference::ALL.len(),
        })
    }

    /// Test specimens of "none of the classes": `count` of each named stranger, and as many empty hands.
    pub fn strangers(label: u32, count: usize) -> Vec<Self> {
        let strangers = Stranger::ALL.map(Specimens::Stranger);
        let all = strangers.into_iter().chain([Specimens::EmptyHand]);
        all.map(|specimens| Self {
            label,
            specimens,
            count,
        })
        .collect()
    }
}

impl Specimens {
    /// One random specimen in the object frame (origin at the bottom's centre, +z up); an empty mesh for an empty hand.
    ///
    /// # Errors
    /// A mesh file cannot be read, or a dent cannot be made.
    pub fn one(&self, parameters: &ScanParameters, random: &mut impl Rng) -> Result<Mesh> {
        match self {
            Self::Class(class) => Ok(sim_scan::dented(*class, parameters, random)?),
            Self::Meshes(meshes) => {
                let mesh = meshes.choose(random).context("there are no meshes")?;
                Ok(mesh.read()?.stood_up())
            }
            Self::Stranger(stranger) => Ok(stranger.mesh()),
            Self::NearStranger(difference, instances) => {
                let NearStranger { class, size } =
                    NearStranger::random(*difference, *instances, random);
                Ok(dented_of_size(class, &size, parameters, random)?)
            }
            Self::RandomSolids => Ok(random_solid(random)),
            Self::EmptyHand => Ok(Mesh::default()),
        }
    }
}
