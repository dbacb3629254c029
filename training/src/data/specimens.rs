//! The objects that clouds are made of, one by one.

use anyhow::{Context, Result};
use mesh::Mesh;
use rand::Rng;
use rand::seq::IndexedRandom;
use sim_objects::{ObjectClass, Stranger, random_solid};
use sim_scan::ScanParameters;

use super::mesh_dataset::MeshFile;

/// Where the specimens of one label come from.
#[derive(Debug, Clone)]
pub enum Specimens {
    /// One of the repository's own objects, dented anew each time.
    Class(ObjectClass),
    /// Meshes of a dataset, +z up, which are dented already; one of them each time.
    Meshes(Vec<MeshFile>),
    /// An object that is none of the classes.
    Stranger(Stranger),
    /// Solids of any form that are none of the eight objects.
    RandomSolids,
    /// No object. Where the camera mount is badly known, the crop leaves something of the gripper.
    EmptyHand,
}

/// Specimens of one label.
#[derive(Debug, Clone)]
pub struct Labelled {
    /// Index of the class; the number of classes for what is none of them.
    pub label: u32,
    /// Where they come from.
    pub specimens: Specimens,
    /// How many.
    pub count: usize,
}

impl Labelled {
    /// As many specimens of each label: meshes where there are any of that name, else the repository's own object.
    ///
    /// # Errors
    /// A label that is neither.
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

    /// What teaches a model to say that something is none of its classes: random solids, and an empty hand for every fifth;
    /// `label` is the number of classes.
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

    /// What tests that: as many of each named stranger, and of empty hands.
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
    /// One specimen in the object frame (bottom centre, +z up); without a surface for an empty hand.
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
            Self::RandomSolids => Ok(random_solid(random)),
            Self::EmptyHand => Ok(Mesh::default()),
        }
    }
}
