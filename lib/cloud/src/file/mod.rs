//! Clouds in PLY and PCD files.
//!
//! [`read`] takes only the points, [`read_surface`] also normals and faces; colours and the like are read over.
//! Coordinates keep the file's unit.

mod pcd;
mod ply;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::Cloud;

/// What is wrong with a file, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The name does not say what the file is.
    #[error("{}: the extension \"{extension}\" is unknown; clouds are read from .ply and .pcd files", path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// What follows the last dot.
        extension: String,
    },
    /// The system refused to read it.
    #[error("{}: cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// There is less in it than its header says.
    #[error("{}: ends too early ({reason}); copy or record it again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// What was missing.
        reason: String,
    },
    /// It holds something else than points.
    #[error("{}: has no numeric x, y, z for each point, only {found}; export it with coordinates", path.display())]
    NoCoordinates {
        /// The file.
        path: PathBuf,
        /// What each point has.
        found: String,
    },
    /// It breaks the rules of its format.
    #[error("{}: is no valid {format} file ({reason}); export it again", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// PLY or PCD.
        format: &'static str,
        /// The rule that it breaks.
        reason: String,
    },
    /// The system refused to write it. What was there before is still there.
    #[error("{}: cannot be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// What a format found wrong, before the file's name is put to it.
#[derive(Debug)]
enum Fault {
    Truncated(String),
    NoCoordinates(String),
    Malformed(String),
}

/// All that a file says about a surface, unchecked but for the indices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// All points, also those that are not finite, in the file's order and unit.
    pub points: Vec<Point3<f32>>,
    /// One a point, of any length; `None` where the file has none.
    pub normals: Option<Vec<Vector3<f32>>>,
    /// Indices into `points`. Faces of more corners are cut into fans, those of fewer are left out.
    pub triangles: Vec<[u32; 3]>,
}

/// What a file holds, before its faces are checked.
#[derive(Debug, Default)]
struct Raw {
    points: Vec<Point3<f32>>,
    normals: Option<Vec<Vector3<f32>>>,
    faces: Vec<Vec<i64>>,
}

/// Reads all that counts of a file's bytes.
type Parse = fn(&[u8]) -> Result<Raw, Fault>;

/// Reads a cloud; `.ply` (ASCII, binary of either byte order) or `.pcd` (ASCII, binary, compressed) by extension.
///
/// Points that are not finite or at (0, 0, 0) are dropped and counted.
pub fn read(path: impl AsRef<Path>) -> Result<Cloud, FileError> {
    let (_, raw) = read_raw(path.as_ref())?;
    Ok(Cloud::clean(raw.points))
}

/// Reads points, normals and faces of the same files; a face that names a point that is not there is refused.
pub fn read_surface(path: impl AsRef<Path>) -> Result<Surface, FileError> {
    let path = path.as_ref();
    let (format, raw) = read_raw(path)?;
    let triangles = triangulated(&raw.faces, raw.points.len())
        .map_err(|fault| name_fault(path, format, fault))?;
    Ok(Surface {
        points: raw.points,
        normals: raw.normals,
        triangles,
    })
}

fn read_raw(path: &Path) -> Result<(&'static str, Raw), FileError> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let (format, parse): (_, Parse) = match extension.as_str() {
        "ply" => ("PLY", ply::parse),
        "pcd" => ("PCD", pcd::parse),
        _ => {
            return Err(FileError::UnknownExtension {
                path: path.to_owned(),
                extension,
            });
        }
    };
    let bytes = fs::read(path).map_err(|source| FileError::Read {
        path: path.to_owned(),
        source,
    })?;
    let raw = parse(&bytes).map_err(|fault| name_fault(path, format, fault))?;
    Ok((format, raw))
}

/// Cuts polygons into fans about their first corner.
fn triangulated(faces: &[Vec<i64>], point_count: usize) -> Result<Vec<[u32; 3]>, Fault> {
    let mut triangles = Vec::with_capacity(faces.len());
    for (number, face) in faces.iter().enumerate() {
        let is_there = |index: i64| usize::try_from(index).is_ok_and(|index| index < point_count);
        if let Some(index) = face.iter().find(|&&index| !is_there(index)) {
            return Err(Fault::Malformed(format!(
                "face {number} names vertex {index}, of vertices 0 to {}",
                point_count as i64 - 1
            )));
        }
        let corners: Vec<u32> = face.iter().map(|&index| index as u32).collect();
        triangles
            .extend((2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]));
    }
    Ok(triangles)
}

/// Writes points as binary little-endian PLY. The file is replaced whole or not at all.
pub fn write_ply(path: impl AsRef<Path>, points: &[Point3<f32>]) -> Result<(), FileError> {
    replace(path.as_ref(), &ply::encode(points))
}

/// Writes points as binary PCD 0.7. The file is replaced whole or not at all.
pub fn write_pcd(path: impl AsRef<Path>, points: &[Point3<f32>]) -> Result<(), FileError> {
    let path = path.as_ref();
    let bytes = pcd::encode(points).map_err(|fault| name_fault(path, "PCD", fault))?;
    replace(path, &bytes)
}

fn name_fault(path: &Path, format: &'static str, fault: Fault) -> FileError {
    let path = path.to_owned();
    match fault {
        Fault::Truncated(reason) => FileError::Truncated { path, reason },
        Fault::NoCoordinates(found) => FileError::NoCoordinates { path, found },
        Fault::Malformed(reason) => FileError::Malformed {
            path,
            format,
            reason,
        },
    }
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    whole_file::write(path, bytes).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Puts several lines of a library's message on one, at most some hundred characters long.
fn one_line(message: &str) -> String {
    const LONGEST: usize = 200;
    let joined = message.split_whitespace().collect::<Vec<_>>().join(" ");
    match joined.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &joined[..end]),
        None => joined,
    }
}

#[cfg(test)]
mod tests;
