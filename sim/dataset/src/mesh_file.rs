//! The file of one mesh.

use std::fs;
use std::path::Path;

use mesh::Mesh;
use mesh::file::{ply_bytes, write_ply};

use crate::digest::hex_digest;
use crate::error::DatasetError;
use crate::manifest::Row;

/// Whether the file is the one that the row was written for. A crash of the machine can have cut it off.
pub fn belongs(path: &Path, row: &Row) -> bool {
    let is_same = |wanted: &String| fs::read(path).is_ok_and(|bytes| hex_digest(&bytes) == *wanted);
    row.sha256.as_ref().is_none_or(is_same)
}

/// Puts a mesh in its place, whole or not at all, and returns the file's digest. A file that an interrupted run left
/// there is only replaced where it is not the same.
///
/// # Errors
/// The file system refuses.
pub fn place(path: &Path, mesh: &Mesh) -> Result<String, DatasetError> {
    let bytes = ply_bytes(mesh);
    if fs::read(path).ok().as_ref() != Some(&bytes) {
        write_ply(path, mesh)?;
    }
    Ok(hex_digest(&bytes))
}
