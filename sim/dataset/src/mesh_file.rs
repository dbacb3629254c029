//! The file of one mesh.

use std::fs;
use std::path::Path;

use mesh::Mesh;
use mesh::file::{ply_bytes, write_ply};

use crate::digest::hex_digest;
use crate::error::DatasetError;
use crate::manifest::Row;

/// Whether the file has the row's digest: after a crash of the machine it may be truncated.
pub fn belongs(path: &Path, row: &Row) -> bool {
    let is_same = |wanted: &String| fs::read(path).is_ok_and(|bytes| hex_digest(&bytes) == *wanted);
    row.sha256.as_ref().is_none_or(is_same)
}

/// Writes a mesh file whole or not at all, and returns its digest. An existing file is replaced only if its bytes differ.
///
/// # Errors
/// The file cannot be written.
pub fn place(path: &Path, mesh: &Mesh) -> Result<String, DatasetError> {
    let bytes = ply_bytes(mesh);
    if fs::read(path).ok().as_ref() != Some(&bytes) {
        write_ply(path, mesh)?;
    }
    Ok(hex_digest(&bytes))
}
