//! The file of one mesh.

use std::fs;
use std::path::Path;

use mesh::Mesh;
use mesh::file::write_ply;

use crate::digest::hex_digest;
use crate::error::DatasetError;
use crate::folder::UNFINISHED;
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
    if !path.exists() {
        write_ply(path, mesh)?;
        return read(path).map(|bytes| hex_digest(&bytes));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let again = path.with_file_name(format!("{UNFINISHED}{name}"));
    write_ply(&again, mesh)?;
    let bytes = read(&again)?;
    if read(path)? == bytes {
        fs::remove_file(&again).map_err(DatasetError::io("remove", &again))?;
    } else {
        fs::rename(&again, path).map_err(DatasetError::io("write", path))?;
    }
    Ok(hex_digest(&bytes))
}

fn read(path: &Path) -> Result<Vec<u8>, DatasetError> {
    fs::read(path).map_err(DatasetError::io("read", path))
}
