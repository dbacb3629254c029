//! Writes files atomically (whole or not at all): into a temporary file beside the target, which is renamed once complete.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("answer.txt");
//! whole_file::write(&path, b"42")?;
//! assert_eq!(std::fs::read(&path)?, b"42");
//! # std::io::Result::Ok(())
//! ```

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Prefix of a temporary file's name. A killed process leaves such files behind.
pub const UNFINISHED: &str = ".unfinished-";

/// Writes a file atomically and flushes it to the disk (fsync). Missing folders are not made.
///
/// # Errors
/// The file cannot be written. A file that existed before is then unchanged, and no temporary file is left.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut draft = Draft::of(path)?;
    draft.file().write_all(bytes)?;
    draft.finish()
}

/// A temporary file that becomes the target when finished. If it is dropped before, it is removed.
#[derive(Debug)]
pub struct Draft {
    file: NamedTempFile,
    target: PathBuf,
}

impl Draft {
    /// Begins a file that will replace or become `path`. If `path` is a symbolic link, its target is replaced. An existing
    /// file keeps its permissions, and a new one gets those of the user's umask.
    ///
    /// # Errors
    /// The folder does not exist, or no file can be written there.
    pub fn of(path: &Path) -> io::Result<Self> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let folder = target.parent().filter(|folder| *folder != Path::new(""));
        let ending = target.extension().map(|extension| {
            let mut ending = std::ffi::OsString::from(".");
            ending.push(extension);
            ending
        });
        let file = tempfile::Builder::new()
            .prefix(UNFINISHED)
            // Some libraries choose a file's format by its extension.
            .suffix(&ending.unwrap_or_default())
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(folder.unwrap_or(Path::new(".")))?;
        if let Ok(there) = fs::metadata(&target)
            .as_ref()
            .map(fs::Metadata::permissions)
        {
            file.as_file().set_permissions(there)?;
        }
        Ok(Self { file, target })
    }

    /// The open temporary file, to write to.
    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Path of the temporary file, for libraries that open files themselves. It has the target's extension.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Flushes the file to the disk (fsync) and renames it to the target.
    ///
    /// # Errors
    /// Flushing or renaming fails. A file that existed before is then unchanged.
    pub fn finish(self) -> io::Result<()> {
        // Opened by name, since a library may have replaced the file under our handle.
        File::open(self.file.path())?.sync_all()?;
        let target = self.target.clone();
        self.finish_unflushed()?;
        let folder = target.parent().filter(|folder| *folder != Path::new(""));
        // Flush the folder, so that the new name survives a loss of power. Not every file system supports this.
        let _ = File::open(folder.unwrap_or(Path::new("."))).and_then(|folder| folder.sync_all());
        Ok(())
    }

    /// Renames the file to the target without flushing: after a loss of power the file may be truncated. For files that can
    /// be made again and whose reader knows their digest.
    ///
    /// # Errors
    /// As [`Draft::finish`].
    pub fn finish_unflushed(self) -> io::Result<()> {
        self.file
            .persist(self.target)
            .map_err(|error| error.error)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
