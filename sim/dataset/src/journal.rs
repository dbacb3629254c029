//! Rows of a run that is not finished. It is also what keeps a second run out of the folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::manifest::{Row, from_csv, to_csv};

/// Rows in the order in which units were finished. A unit's rows are added together, after its meshes are in place.
pub struct Journal {
    file: File,
    path: PathBuf,
    bytes: u64,
}

impl Journal {
    /// Opens or begins a journal and keeps others out until it is dropped, or its process ends.
    ///
    /// # Errors
    /// Another process has it, or the file cannot be made.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let folder = path.parent().unwrap_or(path);
        let in_use = || DatasetError::InUse {
            folder: folder.to_path_buf(),
        };
        let file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(DatasetError::io("open", path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(in_use()),
            // Some cluster file systems have no locks. There the user must not start two runs in one folder.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(DatasetError::io("lock", path)(error)),
        }
        // The other run may have finished and removed the file between our open and our lock.
        let metadata = file.metadata().map_err(DatasetError::io("read", path))?;
        let is_ours = fs::metadata(path).is_ok_and(|there| there.ino() == metadata.ino());
        if !is_ours {
            return Err(in_use());
        }
        Ok(Self {
            file,
            path: path.to_path_buf(),
            bytes: metadata.len(),
        })
    }

    /// Whether nothing is written in it.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }

    /// What earlier runs wrote. A line that a crash cut off is removed.
    ///
    /// # Errors
    /// It cannot be read, or was changed by something else.
    pub fn rows(&mut self) -> Result<Vec<Row>, DatasetError> {
        let mut text = Vec::new();
        self.file
            .read_to_end(&mut text)
            .map_err(DatasetError::io("read", &self.path))?;
        let whole = text.iter().rposition(|&byte| byte == b'\n');
        text.truncate(whole.map_or(0, |end| end + 1));
        self.cut(text.len() as u64)?;
        from_csv(&text).map_err(|error| DatasetError::damaged(&self.path, &error))
    }

    /// Adds the rows of a unit, or none of them.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn append(&mut self, rows: &[Row]) -> Result<(), DatasetError> {
        let text = to_csv(rows, self.is_empty())
            .map_err(|error| DatasetError::damaged(&self.path, &error))?;
        if let Err(error) = self.file.write_all(&text) {
            self.cut(self.bytes)?;
            return Err(DatasetError::io("write", &self.path)(error));
        }
        self.bytes += text.len() as u64;
        Ok(())
    }

    /// Begins anew.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn clear(&mut self) -> Result<(), DatasetError> {
        self.cut(0)
    }

    /// Removes the file, and lets others in.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn remove(self) -> Result<(), DatasetError> {
        fs::remove_file(&self.path).map_err(DatasetError::io("remove", &self.path))
    }

    fn cut(&mut self, bytes: u64) -> Result<(), DatasetError> {
        self.file
            .set_len(bytes)
            .map_err(DatasetError::io("write", &self.path))?;
        self.bytes = bytes;
        Ok(())
    }
}
