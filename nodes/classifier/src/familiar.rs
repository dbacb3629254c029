//! What is like the known objects, by the features that are kept beside a model.

use std::path::Path;

use adaptation::{Familiar, Kept, with_features};
use onnx_file::ModelBuilder;
use sha2::{Digest, Sha256};

use crate::error::LoadError;

/// Reads the features of the model whose bytes these are; gives what is like them, and the bytes of the same model with
/// its features among the outputs.
pub fn read(path: &Path, model: &[u8], features: &Path) -> Result<(Familiar, Vec<u8>), LoadError> {
    let failed = |reason: String| LoadError::Features {
        path: path.to_path_buf(),
        features: features.to_path_buf(),
        reason,
    };
    let bytes = std::fs::read(features).map_err(|error| failed(error.to_string()))?;
    let kept = Kept::decode(&bytes).map_err(|error| failed(error.to_string()))?;
    let digest = Sha256::digest(model);
    let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    if kept.model != digest {
        return Err(failed("it belongs to another model".to_owned()));
    }
    let familiar = Familiar::of_known(&kept.blocks);
    let familiar = familiar.ok_or_else(|| failed("it has no clouds of some object".to_owned()))?;
    let model = ModelBuilder::decode(model).map_err(|error| failed(error.to_string()))?;
    let model = with_features(&model).map_err(|error| failed(error.to_string()))?;
    Ok((familiar, model))
}
