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
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Translation3;

    use super::*;

    fn held(text: &str) -> Held {
        let Ok(held) = text.parse();
        held
    }

    #[test]
    fn a_file_of_millimetres_is_held_upright_like_its_object() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("can.ply");
        let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
        let elsewhere = can.transformed(&Translation3::new(0.3, -0.2, 0.1).into());
        file::write_ply(&path, &elsewhere).unwrap();
        let read = held(path.to_str().unwrap()).mesh(0.0, 1).unwrap().unwrap();
        assert_eq!(read.triangles, can.triangles);
        for (read, own) in read.vertices.iter().zip(&can.vertices) {
            assert!((read - own).norm() < 1e-6, "{read} is not {own}");
        }
        let dented = held(path.to_str().unwrap())
            .mesh(0.008, 1)
            .unwrap()
            .unwrap();
        assert!(dented.volume_m3() < read.volume_m3());
    }

    #[test]
    fn an_object_upside_down_stands_on_its_other_end_and_turns_about_its_axis() {
        let cup = ObjectClass::LargeCup.mesh(&Variation::NONE);
        let held = Grip {
            upside_down: true,
            turn_rad: 0.5,
        }
        .place(&cup);
        let height_m = cup.bounds().1.z;
        for (held, own) in held.vertices.iter().zip(&cup.vertices) {
            assert!((held.z - (height_m - own.z)).abs() < 1e-6);
            assert!((held.x.hypot(held.y) - own.x.hypot(own.y)).abs() < 1e-6);
        }
        assert!((held.volume_m3() - cup.volume_m3()).abs() < 1e-9);
        let turned = Grip {
            turn_rad: 0.5,
            ..Grip::default()
        };
        let angle = |v: &nalgebra::Point3<f32>| v.y.atan2(v.x);
        let (first, own) = (turned.place(&cup).vertices[64], cup.vertices[64]);
        assert!((angle(&first) - angle(&own) - 0.5).abs() < 1e-4);
    }

    #[test]
    fn names_that_mean_nothing_are_refused_with_what_is_meant() {
        assert_eq!(held("").mesh(0.0, 1).unwrap(), None);
        let text = held("teapot").mesh(0.0, 1).unwrap_err().to_string();
        assert!(
            ["teapot", "medium-can", ".ply"]
                .iter()
                .all(|word| text.contains(word)),
            "{text}"
        );
        let text = held("/nowhere/can.ply")
            .mesh(0.0, 1)
            .unwrap_err()
            .to_string();
        assert!(text.contains("/nowhere/can.ply"), "{text}");
        let text = held("small-ball").mesh(0.1, 1).unwrap_err().to_string();
        assert!(text.contains("squeeze is 0.1 m"), "{text}");
    }
}
