//! Whether a network's inputs and outputs are those that a model has.

use std::path::Path;

use ort::session::Session;
use ort::value::{Outlet, TensorElementType};

use crate::error::LoadError;
use crate::metadata::ModelMetadata;
use crate::session::{INPUT_NAME, KNOWN_SCORE_NAME, OUTPUT_NAME};

/// What the model says about itself, if its inputs and outputs are as that asks for.
pub fn checked_metadata(session: &Session, path: &Path) -> Result<ModelMetadata, LoadError> {
    let stored = session.metadata().map_err(|error| LoadError::Corrupt {
        path: path.to_path_buf(),
        reason: error.to_string(),
    })?;
    let metadata = ModelMetadata::from_lookup(|key| stored.custom(key));
    let metadata = metadata.map_err(|source| LoadError::Metadata {
        path: path.to_path_buf(),
        source,
    })?;
    let points = [-1, metadata.columns() as i64, metadata.point_count as i64];
    check_outlet(path, "the input", session.inputs(), INPUT_NAME, &points)?;
    let classes = [-1, metadata.labels.len() as i64];
    let outputs = match session.outputs() {
        [others @ .., last] if is_outlet(last, KNOWN_SCORE_NAME, &[-1]) => others,
        all => all,
    };
    check_outlet(path, "the output", outputs, OUTPUT_NAME, &classes)?;
    Ok(metadata)
}

/// Checks that the only outlet is `name`, float32, of this shape; -1 stands for the batch.
fn check_outlet(
    path: &Path,
    what: &'static str,
    outlets: &[Outlet],
    name: &str,
    shape: &[i64],
) -> Result<(), LoadError> {
    if matches!(outlets, [only] if is_outlet(only, name, shape)) {
        return Ok(());
    }
    let found: Vec<String> = outlets
        .iter()
        .map(|outlet| format!("`{}` {}", outlet.name(), outlet.dtype()))
        .collect();
    Err(LoadError::Interface {
        path: path.to_path_buf(),
        what,
        found: found.join(" and "),
        expected: format!("`{name}` float32 {shape:?} (-1: any; sizes as in the metadata)"),
    })
}

fn is_outlet(outlet: &Outlet, name: &str, shape: &[i64]) -> bool {
    let sizes = outlet.dtype().tensor_shape();
    outlet.name() == name
        && outlet.dtype().tensor_type() == Some(TensorElementType::Float32)
        && sizes.is_some_and(|sizes| **sizes == *shape)
}
