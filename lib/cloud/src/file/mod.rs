//! Clouds in PLY and PCD files.
//!
//! [`read`] takes only the points, [`read_surface`] also normals and faces; colours and the like are read over.
//! Coordinates keep the file's unit.

mod error;
mod pcd;
mod ply;

use std::fs;
use std::path::Path;

use nalgebra::{Point3, Vector3};

use crate::{Cloud, Dropped};

use error::Fault;
pub use error::FileError;

/// All that a file says about a surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// Points in the file's order and unit. Those of a mere cloud are finite and not at (0, 0, 0); of a mesh, those that
    /// a triangle names may be both.
    pub points: Vec<Point3<f32>>,
    /// One a point, of any length; `None` where the file has none.
    pub normals: Option<Vec<Vector3<f32>>>,
    /// Indices into `points`. Faces of more corners are cut into fans, those of fewer are left out.
    pub triangles: Vec<[u32; 3]>,
    /// Points left out.
    pub dropped: Dropped,
}

/// What a file holds; the triangles name points that are there.
#[derive(Debug, Default)]
struct Raw {
    points: Vec<Point3<f32>>,
    normals: Option<Vec<Vector3<f32>>>,
    triangles: Vec<[u32; 3]>,
}

impl Raw {
    /// For so many points, which a file holds.
    fn with_capacity(points: usize, has_normals: bool) -> Self {
        Self {
            points: Vec::with_capacity(points),
            normals: has_normals.then(|| Vec::with_capacity(points)),
            triangles: Vec::new(),
        }
    }

    fn push(&mut self, point: [f32; 3], normal: Option<[f32; 3]>) {
        self.points.push(point.into());
        if let (Some(normals), Some(normal)) = (&mut self.normals, normal) {
            normals.push(normal.into());
        }
    }
}

/// Reads all that counts of a file's bytes.
type Parse = fn(&[u8]) -> Result<Raw, Fault>;

/// Reads a cloud; `.ply` (ASCII, binary of either byte order) or `.pcd` (ASCII, binary, compressed) by extension.
///
/// Points that are not finite or at (0, 0, 0) are dropped and counted.
///
/// # Errors
/// [`FileError`] where the file cannot be read, is cut short, breaks its format's rules or has no coordinates.
pub fn read(path: impl AsRef<Path>) -> Result<Cloud, FileError> {
    let (_, raw) = read_raw(path.as_ref())?;
    Ok(Cloud::clean(raw.points))
}

/// Reads points, normals and faces of a file in one of these formats.
///
/// Points that are not finite or at (0, 0, 0) are dropped and counted, as by [`read`], except those that a face names: a
/// mesh may pass through the origin.
///
/// # Errors
/// Those of [`read`], and a face that names a point that does not exist.
pub fn read_surface(path: impl AsRef<Path>) -> Result<Surface, FileError> {
    let path = path.as_ref();
    let (format, raw) = read_raw(path)?;
    let fault = |vertex: Unmeasured| {
        let fault = Fault::malformed(
            vertex.to_string(),
            "remove faces of vertices that are not finite",
        );
        fault.of(path, format)
    };
    Surface::measured(raw.points, raw.normals, raw.triangles).map_err(fault)
}

/// A corner of a face that is no measurement.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("vertex {index} of a face is at {point}")]
pub struct Unmeasured {
    /// Index of the vertex, from 0.
    pub index: usize,
    /// Its coordinates in the file.
    pub point: Point3<f32>,
}

impl Surface {
    /// Leaves out points that are no measurements, by the rules of [`read_surface`].
    ///
    /// # Errors
    /// A triangle names a point that is not finite.
    ///
    /// # Panics
    /// If a triangle names a point that does not exist, or if the numbers of normals and points differ.
    pub fn measured(
        mut points: Vec<Point3<f32>>,
        mut normals: Option<Vec<Vector3<f32>>>,
        mut triangles: Vec<[u32; 3]>,
    ) -> Result<Self, Unmeasured> {
        let mut is_kept = vec![false; points.len()];
        for index in triangles.iter().flatten().map(|&corner| corner as usize) {
            is_kept[index] = true;
            if !crate::is_finite(&points[index]) {
                let point = points[index];
                return Err(Unmeasured { index, point });
            }
        }
        let mut dropped = Dropped::default();
        for (point, is_kept) in points.iter().zip(&mut is_kept) {
            *is_kept = *is_kept || dropped.is_measured(point);
        }
        if dropped.count() > 0 {
            renumber(&mut triangles, &is_kept);
            keep(&mut points, &is_kept);
            if let Some(normals) = &mut normals {
                keep(normals, &is_kept);
            }
        }
        Ok(Self {
            points,
            normals,
            triangles,
            dropped,
        })
    }
}

fn keep<T>(all: &mut Vec<T>, is_kept: &[bool]) {
    let mut is_kept = is_kept.iter();
    all.retain(|_| is_kept.next().is_some_and(|&is_kept| is_kept));
}

/// Replaces the triangles' indices by indices among the kept points.
fn renumber(triangles: &mut [[u32; 3]], is_kept: &[bool]) {
    let mut kept = 0;
    let place = |&is_kept: &bool| {
        kept += u32::from(is_kept);
        kept.saturating_sub(1)
    };
    let places: Vec<u32> = is_kept.iter().map(place).collect();
    for corner in triangles.iter_mut().flatten() {
        *corner = places[*corner as usize];
    }
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
    let raw = parse(&bytes).map_err(|fault| fault.of(path, format))?;
    Ok((format, raw))
}

/// Writes points as binary little-endian PLY. The file is replaced whole or not at all.
///
/// # Errors
/// [`FileError::Write`] if the file cannot be written; a file that existed before is then unchanged.
pub fn write_ply(path: impl AsRef<Path>, points: &[Point3<f32>]) -> Result<(), FileError> {
    replace(path.as_ref(), &ply::encode(points))
}

/// Writes points as binary PCD 0.7. The file is replaced whole or not at all.
///
/// # Errors
/// [`FileError::Write`] if the file cannot be written; a file that existed before is then unchanged.
pub fn write_pcd(path: impl AsRef<Path>, points: &[Point3<f32>]) -> Result<(), FileError> {
    write_pcd_with(path.as_ref(), points, None)
}

/// The same with a field of one more number for each point.
///
/// # Errors
/// As [`write_pcd`].
///
/// # Panics
/// There are not as many numbers as points.
pub fn write_pcd_field(
    path: impl AsRef<Path>,
    points: &[Point3<f32>],
    name: &str,
    values: &[f32],
) -> Result<(), FileError> {
    assert_eq!(points.len(), values.len());
    write_pcd_with(path.as_ref(), points, Some((name, values)))
}

fn write_pcd_with(
    path: &Path,
    points: &[Point3<f32>],
    more: Option<(&str, &[f32])>,
) -> Result<(), FileError> {
    let bytes = pcd::encode(points, more).map_err(|fault| fault.of(path, "PCD"))?;
    replace(path, &bytes)
}

fn replace(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    whole_file::write(path, bytes).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Joins the lines of a library's message and limits its length to 200 characters.
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
