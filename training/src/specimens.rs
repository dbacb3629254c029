//! The objects that clouds are made of, one by one.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};
use sim_objects::{Mesh, ObjectClass, Stranger, Variation, file, random_solid};

use crate::scan_parameters::ScanParameters;

/// Where the specimens of one label come from.
#[derive(Debug, Clone)]
pub enum Specimens {
    /// One of the repository's own objects, dented anew each time.
    Class(ObjectClass),
    /// Mesh files (mm, +z up) of objects that are dented already; one of them each time.
    Meshes(Vec<PathBuf>),
    /// An object that is none of the classes.
    Stranger(Stranger),
    /// Solids of any form that are none of the eight objects.
    RandomSolids,
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
    /// As many specimens of each of the repository's own objects.
    pub fn classes(count: usize) -> Vec<Self> {
        let labelled = |(label, class): (usize, ObjectClass)| Self {
            label: label as u32,
            specimens: Specimens::Class(class),
            count,
        };
        ObjectClass::ALL
            .into_iter()
            .enumerate()
            .map(labelled)
            .collect()
    }

    /// So many random solids; `label` is the number of classes.
    pub fn random_solids(label: u32, count: usize) -> Self {
        Self {
            label,
            specimens: Specimens::RandomSolids,
            count,
        }
    }

    /// As many of each named stranger; `label` is the number of classes.
    pub fn strangers(label: u32, count: usize) -> Vec<Self> {
        let labelled = |stranger| Self {
            label,
            specimens: Specimens::Stranger(stranger),
            count,
        };
        Stranger::ALL.into_iter().map(labelled).collect()
    }
}

impl Specimens {
    /// One specimen in the object frame (bottom centre, +z up).
    ///
    /// # Errors
    /// A mesh file cannot be read, or a dent cannot be made.
    pub fn one(&self, parameters: &ScanParameters, random: &mut impl Rng) -> Result<Mesh> {
        match self {
            Self::Class(class) => {
                let variation = Variation::random(random.random());
                let dented = !random.random_bool(parameters.undented_share);
                let squeeze_m = if dented {
                    random.random_range(0.0..=parameters.squeeze_max_m)
                } else {
                    0.0
                };
                Ok(sim_deform::specimen(
                    *class,
                    &variation,
                    squeeze_m,
                    random.random(),
                )?)
            }
            Self::Meshes(paths) => {
                let path = paths.choose(random).context("there are no meshes")?;
                let scan = file::read(path, file::MILLIMETRE)?;
                ensure!(
                    !scan.is_cloud(),
                    "{} has no faces; make meshes with generate_dataset",
                    path.display()
                );
                Ok(scan.mesh().stood_up())
            }
            Self::Stranger(stranger) => Ok(stranger.mesh()),
            Self::RandomSolids => Ok(random_solid(random)),
        }
    }
}
