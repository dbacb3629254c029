//! What is like the known objects, by the features that are kept beside a model.

use std::path::Path;

use adaptation::{Familiar, features_of, features_path, read_features, with_features};
use onnx_file::ModelBuilder;
use sha2::{Digest, Sha256};

use crate::error::LoadError;

/// Where the features of what a model knows come from.
#[derive(Debug, Clone, Copy)]
pub enum Features<'a> {
    /// The file beside the model.
    Beside,
    /// Another file.
    File(&'a Path),
    /// Nowhere: the network's own score tells what is known, for which the threshold may not be meant.
    Unused,
}

/// Reads the features of the model whose bytes these are, if any are to be used; gives what is like them, and the bytes of the same model with
/// its features among the outputs.
pub fn read(
    path: &Path,
    model: &[u8],
    features: Features,
) -> Result<Option<(Familiar, Vec<u8>)>, LoadError> {
    let failed = |reason: String| LoadError::Features {
        path: path.to_path_buf(),
        features: match features {
            Features::File(file) => file.to_path_buf(),
            Features::Beside | Features::Unused => features_path(path),
        },
        reason,
    };
    let digest = Sha256::digest(model);
    let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    let kept = match features {
        Features::Unused => return Ok(None),
        Features::Beside => features_of(path, &digest),
        Features::File(file) => read_features(file, &digest),
    };
    let kept = kept.map_err(|error| failed(error.to_string()))?;
    let familiar = Familiar::of_known(&kept.blocks);
    let familiar = familiar.ok_or_else(|| failed("it has no clouds of some object".to_owned()))?;
    let model = ModelBuilder::decode(model).map_err(|error| failed(error.to_string()))?;
    let model = with_features(&model).map_err(|error| failed(error.to_string()))?;
    Ok(Some((familiar, model)))
}
