//! Which energy makes a deformation.

use arap::{Arap, ArapError, ArapSettings, Deformed, Grip, Laplacian, LaplacianGrip};
use mesh::Mesh;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

/// The energy that a deformation minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Energy {
    /// As rigid as possible, edge by edge; constraints are held.
    #[default]
    Rigid,
    /// Eq. 3 of the paper as printed: differences of Laplacian vectors; constraints draw.
    Laplacian,
}

/// A source mesh with either energy.
#[derive(Debug, Clone)]
pub(crate) enum Deformer {
    Rigid(Box<Arap>),
    Laplacian(Laplacian),
}

/// One with handles.
pub(crate) enum Gripped<'a> {
    Rigid(Box<Grip<'a>>),
    Laplacian(LaplacianGrip<'a>),
}

impl Deformer {
    pub fn new(
        mesh: &Mesh,
        held: &[u32],
        energy: Energy,
        settings: ArapSettings,
    ) -> Result<Self, ArapError> {
        Ok(match energy {
            Energy::Rigid => Self::Rigid(Box::new(Arap::new(mesh, held, settings)?)),
            Energy::Laplacian => Self::Laplacian(Laplacian::new(mesh, held, settings)?),
        })
    }

    pub fn grip(&self, handles: &[u32]) -> Result<Gripped<'_>, ArapError> {
        Ok(match self {
            Self::Rigid(source) => Gripped::Rigid(Box::new(source.grip(handles)?)),
            Self::Laplacian(source) => Gripped::Laplacian(source.grip(handles)?),
        })
    }
}

impl Gripped<'_> {
    pub fn deform(&mut self, targets_m: &[Point3<f64>]) -> Result<Deformed, ArapError> {
        match self {
            Self::Rigid(grip) => grip.deform(targets_m),
            Self::Laplacian(grip) => grip.deform(targets_m),
        }
    }
}
