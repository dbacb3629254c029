//! Scans and meshes in files: PLY, OBJ and PCD are read, PLY is written.
//!
//! A file does not say its unit: the reader is told how many metres one is. What is written is in millimetres.

mod obj;
mod ply;

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

pub use ply::{ply_bytes, write_ply};

/// What one unit of a file in millimetres is, in metres.
pub const MILLIMETRE: f64 = 0.001;

/// What a scanner gives: points, perhaps with normals, perhaps joined to triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scan {
    /// Finite points in metres, at least one.
    pub points_m: Vec<Point3<f32>>,
    /// Unit normals, one a point; `None` where the file has none, or where one of them has no direction.
    pub normals: Option<Vec<Vector3<f32>>>,
    /// Indices into `points_m`; empty for a mere cloud. Larger faces are cut into triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl Scan {
    /// Whether there are only points.
    pub fn is_cloud(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The points and triangles, as they are.
    pub fn mesh(&self) -> Mesh {
        Mesh {
            vertices: self.points_m.clone(),
            triangles: self.triangles.clone(),
        }
    }
}

impl From<Mesh> for Scan {
    fn from(mesh: Mesh) -> Self {
        Self {
            points_m: mesh.vertices,
            normals: None,
            triangles: mesh.triangles,
        }
    }
}

/// What is wrong with a file, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The name does not say what the file is.
    #[error("{}: the extension \"{extension}\" is unknown; scans are .ply, .obj or .pcd files", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// What follows the last dot.
        extension: String,
    },
    /// A PLY or PCD file that cannot be read, is cut short or breaks the rules of its format.
    #[error(transparent)]
    Cloud(#[from] cloud::FileError),
    /// The system refused to read it.
    #[error("{}: cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// An OBJ file that breaks the rules of its format.
    #[error("{}, line {line}: {reason}; export it again", path.display())]
    Obj {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// The rule that it breaks.
        reason: String,
    },
    /// Nothing to work with.
    #[error("{}: has no vertices; export it again", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A coordinate that is NaN or infinite, or too large once it is in metres.
    #[error("{}: vertex {index} is at {point}; remove vertices that are not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Counted from 0.
        index: usize,
        /// As in the file.
        point: Point3<f32>,
    },
    /// Nothing can be measured in such a unit.
    #[error(
        "{metres_per_unit} metres per unit of a file; give a positive number, 0.001 for millimetres"
    )]
    Unit {
        /// What was asked for.
        metres_per_unit: f64,
    },
    /// The system refused to write it. What was there before is still there.
    #[error("{}: cannot be written; is there space, and may you write there?", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Reads a scan; `.ply`, `.obj` or `.pcd` by extension. `metres_per_unit` is 0.001 for a file in millimetres.
///
/// # Errors
/// [`FileError`] where the file cannot be read, is cut short or breaks its format's rules, where a face names a vertex
/// that is not there, where a coordinate is not finite, and where there are no vertices.
pub fn read(path: impl AsRef<Path>, metres_per_unit: f64) -> Result<Scan, FileError> {
    let path = path.as_ref();
    if !(metres_per_unit.is_finite() && metres_per_unit > 0.0) {
        return Err(FileError::Unit { metres_per_unit });
    }
    let extension = path.extension().unwrap_or(OsStr::new(""));
    let extension = extension.to_string_lossy().to_lowercase();
    let surface = match extension.as_str() {
        "ply" | "pcd" => cloud::read_surface(path)?,
        "obj" => read_obj(path)?,
        _ => {
            return Err(FileError::UnknownExtension {
                path: path.to_owned(),
                extension,
            });
        }
    };
    scan(path, surface, metres_per_unit)
}

fn read_obj(path: &Path) -> Result<cloud::Surface, FileError> {
    let bytes = fs::read(path).map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    obj::parse(&String::from_utf8_lossy(&bytes)).map_err(|fault| FileError::Obj {
        path: path.to_owned(),
        line: fault.line,
        reason: fault.reason,
    })
}

/// Puts a surface into metres, checked.
fn scan(path: &Path, surface: cloud::Surface, metres_per_unit: f64) -> Result<Scan, FileError> {
    let in_metres = |point: &Point3<f32>| {
        let coordinates = point.coords.cast::<f64>() * metres_per_unit;
        Point3::from(coordinates.cast::<f32>())
    };
    let points_m: Vec<_> = surface.points.iter().map(in_metres).collect();
    if points_m.is_empty() {
        return Err(FileError::Empty {
            path: path.to_owned(),
        });
    }
    if let Some(index) = points_m.iter().position(|point| !cloud::is_finite(point)) {
        return Err(FileError::NotFinite {
            path: path.to_owned(),
            index,
            point: surface.points[index],
        });
    }
    let unit = |normal: &Vector3<f32>| {
        let unit = normal.cast::<f64>().try_normalize(0.0)?.cast::<f32>();
        unit.iter().all(|part| part.is_finite()).then_some(unit)
    };
    Ok(Scan {
        points_m,
        normals: surface
            .normals
            .and_then(|normals| normals.iter().map(unit).collect()),
        triangles: surface.triangles,
    })
}

#[cfg(test)]
mod tests;
