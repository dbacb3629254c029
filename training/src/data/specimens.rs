//! Specimens: the single objects that are scanned.

use anyhow::{Context, Result};
use mesh::Mesh;
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use sim_objects::{
    Difference, Instance, Instances, NearStranger, ObjectClass, Stranger, random_solid,
};
use sim_scan::{ScanParameters, dented, dented_instance};

use super::mesh_dataset::MeshFile;

/// Share of the training specimens of a family that are its traced object: the one that the paper's laboratory has.
const TRACED_SHARE: f64 = 0.5;

/// Where the specimens of one label come from.
#[derive(Debug, Clone)]
pub enum Specimens {
    /// One of the very objects that were traced from scans; each specimen has a new random dent.
    Traced(ObjectClass),
    /// Instances of a class's family, each with a new random dent; half of those to learn from are the traced object.
    Family(ObjectClass, Instances),
    /// Dented meshes of a dataset, +z up; each specimen is a random one of them.
    Meshes(Vec<MeshFile>),
    /// An object that is none of the classes.
    Stranger(Stranger),
    /// Dented objects of the eight's kinds and nearly the sizes of their families.
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
    /// The same number of specimens of each label to learn from: meshes if there are any of that name, otherwise instances of the
    /// family of one of the eight.
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
                Specimens::Family(name.parse()?, Instances::Training)
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

    /// Training specimens of "none of the classes" that are like one of them: `count` in all. Those that are less than 5 % off are
    /// not learned from: a dent or a side pressed flat changes an object of a class by as much, and it shall stay known.
    pub fn near_strangers(label: u32, count: usize) -> [Self; 2] {
        [Difference::To10, Difference::To20].map(|difference| Self {
            label,
            specimens: Specimens::NearStranger(difference, Instances::Training),
            count: count / 2,
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
            Self::Traced(class) => Ok(dented(*class, parameters, random)?),
            Self::Family(class, instances) => {
                if *instances == Instances::Training && random.random_bool(TRACED_SHARE) {
                    return Ok(dented(*class, parameters, random)?);
                }
                let instance = Instance::random(*class, *instances, random);
                Ok(dented_instance(&instance, parameters, random)?)
            }
            Self::Meshes(meshes) => {
                let mesh = meshes.choose(random).context("there are no meshes")?;
                Ok(mesh.read()?.stood_up())
            }
            Self::Stranger(stranger) => Ok(stranger.mesh()),
            Self::NearStranger(difference, instances) => {
                let stranger = NearStranger::random(*difference, *instances, random);
                Ok(dented_instance(&stranger.instance, parameters, random)?)
            }
            Self::RandomSolids => Ok(random_solid(random)),
            Self::EmptyHand => Ok(Mesh::default()),
        }
    }
}
