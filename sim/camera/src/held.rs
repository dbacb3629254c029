//! What the simulated hand holds, by name.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use mesh::Mesh;
use mesh::file::{self, FileError};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use sim_deform::SqueezeError;
use sim_objects::{ObjectClass, UnknownObject, Variation};

/// An object as parameters and requests name it.
#[derive(Debug, Clone, PartialEq)]
pub enum Held {
    /// The empty text: nothing.
    Nothing,
    /// One of the eight objects.
    Class(ObjectClass),
    /// The path of a mesh file: PLY or OBJ, millimetres, +z up.
    File(PathBuf),
    /// A text that is neither.
    Unknown(UnknownObject),
}

/// An object that cannot be held.
#[derive(Debug, thiserror::Error)]
pub enum HeldError {
    /// Neither an object nor a mesh file.
    #[error("{0}, or the path of a mesh (.ply or .obj, millimetres, +z up)")]
    Unknown(#[from] UnknownObject),
    /// The mesh file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// It has points and no triangles.
    #[error("{}: has no faces; make a mesh of the scan first", path.display())]
    NoFaces {
        /// The file.
        path: PathBuf,
    },
    /// It cannot be dented so.
    #[error(transparent)]
    Squeeze(#[from] SqueezeError),
}

impl FromStr for Held {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        let path = PathBuf::from(text);
        Ok(match text.parse() {
            _ if text.is_empty() => Self::Nothing,
            Ok(class) => Self::Class(class),
            Err(_) if path.extension().is_some() => Self::File(path),
            Err(unknown) => Self::Unknown(unknown),
        })
    }
}

impl Held {
    /// The object in its own frame (bottom centre, +z up), dented by `squeeze_m` from each side; `None` for nothing. The
    /// seed tells where the dent is and how a specimen of a class differs from the table.
    ///
    /// # Errors
    /// [`HeldError`]: there is no such object, or it cannot be dented so.
    pub fn mesh(&self, squeeze_m: f64, seed: u64) -> Result<Option<Mesh>, HeldError> {
        Ok(match self {
            Self::Nothing => None,
            Self::Unknown(unknown) => return Err(unknown.clone().into()),
            Self::Class(class) => {
                let variation = Variation::random(seed);
                Some(sim_deform::specimen(*class, &variation, squeeze_m, seed)?)
            }
            Self::File(path) => {
                let scan = file::read(path, file::MILLIMETRE)?;
                if scan.is_cloud() {
                    return Err(HeldError::NoFaces { path: path.clone() });
                }
                let mesh = sim_deform::squeeze(scan.mesh(), squeeze_m, seed)?;
                Some(mesh.stood_up())
            }
        })
    }
}

/// How an object stands between the fingers.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Grip {
    /// Whether its upper end is held.
    pub upside_down: bool,
    /// How far it is turned about its own axis, rad.
    pub turn_rad: f64,
}

impl Grip {
    /// An object (in its own frame: bottom centre, +z up) as it is held, in the frame of one that is held upright.
    pub fn place(&self, object: &Mesh) -> Mesh {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.turn_rad);
        let turned = Isometry3::from_parts(Default::default(), turn.cast());
        if !self.upside_down {
            return object.transformed(&turned);
        }
        let over = Isometry3::rotation(Vector3::x() * std::f32::consts::PI);
        let height_m = object.bounds().1.z;
        let mut held = object.transformed(&(turned * over));
        held.vertices.iter_mut().for_each(|v| v.z += height_m);
        held
    }
}

#[cfg(test)]
mod tests;
