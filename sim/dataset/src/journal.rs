//! Rows of an unfinished run. Its lock also keeps a second run out of the folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::manifest::{Row, from_csv, to_csv};

/// The file of rows, in the order in which units were finished. The rows of a unit are appended together, after its meshes
/// have been written.
pub struct Journal {
    file: File,
    path: PathBuf,
    bytes: u64,
}

impl Journal {
    /// Opens or creates a journal, and locks it until it is dropped or its process ends.
    ///
    /// # Errors
    /// Another process has locked it, or the file cannot be made.
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

    /// Whether the file is empty.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }

    /// Reads the rows of earlier runs. A last line that a crash cut off is removed from the file.
    ///
    /// # Errors
    /// The file cannot be read, or is not as this program writes it.
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

    /// Appends the rows of a unit: all of them, or none if writing fails.
    ///
    /// # Errors
    /// The file cannot be written.
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

    /// Removes all rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn clear(&mut self) -> Result<(), DatasetError> {
        self.cut(0)
    }

    /// Removes the file and its lock.
    ///
    /// # Errors
    /// The file cannot be removed.
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
