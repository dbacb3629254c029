//! Scans and meshes in files: PLY, OBJ and PCD are read, PLY is written.
//!
//! A file does not say its unit: the reader is told how many metres one is. What is written is in millimetres.

mod obj;
mod ply;

use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use cloud::{Dropped, Unmeasured};
use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

pub use ply::{ply_bytes, write_ply};

/// Length of a file's unit in metres, for files in millimetres.
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
    /// Number of points of the file that are no measurements and were left out.
    pub dropped: Dropped,
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
            dropped: Dropped::default(),
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
    #[error("{}, line {line}: {reason}; correct that line, or export it again", path.display())]
    Obj {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// The rule that it breaks.
        reason: String,
    },
    /// No vertex is a measurement.
    #[error("{}: has no vertices that were measured{}; scan or export it again", path.display(), of(dropped))]
    Empty {
        /// The file.
        path: PathBuf,
        /// Number of vertices that were left out because they are no measurements.
        dropped: Dropped,
    },
    /// A vertex of a face that is NaN or infinite, or a coordinate that becomes infinite when it is converted to metres.
    #[error("{}: {vertex}; remove faces of vertices that are not finite", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The first such vertex.
        vertex: Unmeasured,
    },
    /// A unit that is not a positive number.
    #[error(
        "{metres_per_unit} metres per unit of a file; give a positive number, 0.001 for millimetres"
    )]
    Unit {
        /// What was asked for.
        metres_per_unit: f64,
    },
    /// The file could not be written. A file that existed before is unchanged.
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
/// that is not there or not finite, and where there are no vertices.
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
    let raw = obj::parse(&bytes).map_err(|fault| FileError::Obj {
        path: path.to_owned(),
        line: fault.line,
        reason: fault.reason,
    })?;
    drop(bytes);
    let surface = cloud::Surface::measured(raw.points, raw.normals, raw.triangles);
    surface.map_err(|vertex| FileError::NotFinite {
        path: path.to_owned(),
        vertex,
    })
}

fn of(dropped: &Dropped) -> String {
    match dropped.count() {
        0 => String::new(),
        count => format!(" ({count} are not finite or at (0, 0, 0))"),
    }
}

/// Converts a surface to metres and checks it.
fn scan(path: &Path, surface: cloud::Surface, metres_per_unit: f64) -> Result<Scan, FileError> {
    let in_metres = |point: &Point3<f32>| {
        let coordinates = point.coords.cast::<f64>() * metres_per_unit;
        Point3::from(coordinates.cast::<f32>())
    };
    let mut points_m = surface.points;
    if points_m.is_empty() {
        return Err(FileError::Empty {
            path: path.to_owned(),
            dropped: surface.dropped,
        });
    }
    for (index, point) in points_m.iter_mut().enumerate() {
        let point_m = in_metres(point);
        if !cloud::is_finite(&point_m) {
            return Err(FileError::NotFinite {
                path: path.to_owned(),
                vertex: Unmeasured {
                    index,
                    point: *point,
                },
            });
        }
        *point = point_m;
    }
    Ok(Scan {
        points_m,
        normals: surface.normals.and_then(unit_vectors),
        triangles: surface.triangles,
        dropped: surface.dropped,
    })
}

/// `None` if one of them has no direction.
fn unit_vectors(mut normals: Vec<Vector3<f32>>) -> Option<Vec<Vector3<f32>>> {
    for normal in &mut normals {
        *normal = normal.cast::<f64>().try_normalize(0.0)?.cast();
        if !normal.iter().all(|part| part.is_finite()) {
            return None;
        }
    }
    Some(normals)
}

#[cfg(test)]
mod tests;
