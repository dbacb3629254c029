//! Which file has the features of a model.

use std::io;
use std::path::{Path, PathBuf};

use crate::kept::{Kept, KeptError};

/// Where the features of a model are: beside its file, with the ending `.features`.
pub fn features_path(model: &Path) -> PathBuf {
    model.with_extension("features")
}

/// Where a model of before is kept, by the digest of its file: MODEL.before/DIGEST.onnx.
pub fn copy_path(model: &Path, digest: &str) -> PathBuf {
    model
        .with_extension("before")
        .join(format!("{digest}.onnx"))
}

/// Why there are no features of a model.
#[derive(Debug, thiserror::Error)]
pub enum FeaturesError {
    /// There is no such file.
    #[error("there is no file {}", .0.display())]
    Missing(PathBuf),
    /// The system cannot read the file.
    #[error("cannot read {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file has no features.
    #[error("{}: {source}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        source: KeptError,
    },
    /// The file has features of another model.
    #[error("{} belongs to another model", .0.display())]
    OtherModel(PathBuf),
}

/// Reads the features of a model; `digest` is the SHA-256 of the model file. Every change of a model first keeps a copy of the old model
/// and its features, then replaces the features, and the model last. If it was killed between the last two steps, the features
/// beside the model do not belong to it, and the kept copy is read.
///
/// # Errors
/// Neither file has features of this model.
pub fn features_of(model: &Path, digest: &str) -> Result<Kept, FeaturesError> {
    let beside = read_features(&features_path(model), digest);
    if let Err(FeaturesError::Missing(_) | FeaturesError::OtherModel(_)) = beside {
        let copy = features_path(&copy_path(model, digest));
        if copy.is_file() {
            return read_features(&copy, digest);
        }
    }
    beside
}

/// Reads a file of features of the model whose file has this SHA-256.
///
/// # Errors
/// The file cannot be read, has no features, or those of another model.
pub fn read_features(path: &Path, digest: &str) -> Result<Kept, FeaturesError> {
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => FeaturesError::Missing(path.to_path_buf()),
        _ => FeaturesError::Unreadable {
            path: path.to_path_buf(),
            source,
        },
    })?;
    let kept = Kept::decode(&bytes).map_err(|source| FeaturesError::Damaged {
        path: path.to_path_buf(),
        source,
    })?;
    if kept.model != digest {
        return Err(FeaturesError::OtherModel(path.to_path_buf()));
    }
    Ok(kept)
}
