//! Writing binary PLY.

use std::io::{self, Write};
use std::path::Path;

use whole_file::Draft;

use super::{FileError, MILLIMETRE};
use crate::mesh::Mesh;

/// Writes a mesh in millimetres as binary little-endian PLY: float vertices, faces as uchar and uint lists.
///
/// The same mesh gives the same bytes, those of [`ply_bytes`]. The file appears whole or not at all; it is not flushed to
/// the disk, since it can be made again.
///
/// # Errors
/// [`FileError::Write`] if the file cannot be written; a file that existed before is then unchanged.
pub fn write_ply(path: impl AsRef<Path>, mesh: &Mesh) -> Result<(), FileError> {
    let path = path.as_ref();
    replace(path, &ply_bytes(mesh)).map_err(|source| FileError::Write {
        path: path.to_owned(),
        source,
    })
}

/// The bytes of the file that [`write_ply`] writes.
pub fn ply_bytes(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex {}\nproperty float x\n\
         property float y\nproperty float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    bytes.reserve(12 * mesh.vertices.len() + 13 * mesh.triangles.len());
    for vertex in &mesh.vertices {
        for &coordinate_m in vertex.iter() {
            let coordinate_mm = (f64::from(coordinate_m) / MILLIMETRE) as f32;
            bytes.extend(coordinate_mm.to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut draft = Draft::of(path)?;
    draft.file().write_all(bytes)?;
    draft.finish_unflushed()
}
