//! Errors of reading and writing clouds.

use std::io;
use std::path::{Path, PathBuf};

use crate::text::Utf16;

/// What is wrong with a file, and the remedy.
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
    #[error("{}: ends too early ({reason}); copy or record it again, or correct its header", path.display())]
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
    #[error("{}: is no valid {format} file ({reason}); {remedy}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// PLY or PCD.
        format: &'static str,
        /// The rule that it breaks.
        reason: String,
        /// What can be done.
        remedy: &'static str,
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

/// A fault that a format's parser found, without the file's name.
#[derive(Debug)]
pub(super) enum Fault {
    Truncated(String),
    NoCoordinates(String),
    Malformed {
        reason: String,
        remedy: &'static str,
    },
}

impl Fault {
    pub(super) fn malformed(reason: impl Into<String>, remedy: &'static str) -> Self {
        Self::Malformed {
            reason: reason.into(),
            remedy,
        }
    }

    /// The error for the file in which it was found.
    pub(super) fn of(self, path: &Path, format: &'static str) -> FileError {
        let path = path.to_owned();
        match self {
            Self::Truncated(reason) => FileError::Truncated { path, reason },
            Self::NoCoordinates(found) => FileError::NoCoordinates { path, found },
            Self::Malformed { reason, remedy } => FileError::Malformed {
                path,
                format,
                reason,
                remedy,
            },
        }
    }
}

impl From<Utf16> for Fault {
    fn from(error: Utf16) -> Self {
        Self::malformed(error.to_string(), "save it as UTF-8")
    }
}
