//! What a network makes of a cloud inside, in place of its answer.

use std::path::Path;

use ort::session::Session;
use ort::value::TensorRef;

use crate::error::{ClassifyError, LoadError};
use crate::metadata::ModelMetadata;
use crate::session::INPUT_NAME;
use crate::{runtime, session};

/// A network of which another output than the answer is asked for. Runs on ONNX Runtime's own code.
#[derive(Debug)]
pub struct Extractor {
    session: Session,
    metadata: ModelMetadata,
    output: String,
}

impl Extractor {
    /// An extractor for the ONNX model in `bytes`, whose graph has an output named `output`: float32, shape `[B, F]`. Errors name `path`.
    ///
    /// # Errors
    /// ONNX Runtime is missing, or refuses the bytes.
    pub fn new(
        bytes: &[u8],
        metadata: &ModelMetadata,
        output: &str,
        path: &Path,
    ) -> Result<Self, LoadError> {
        let session = session::cpu(runtime::environment()?, bytes);
        let session = session.map_err(|reason| LoadError::Corrupt {
            path: path.to_path_buf(),
            reason,
        })?;
        Ok(Self {
            session,
            metadata: metadata.clone(),
            output: output.to_owned(),
        })
    }

    /// Runs the network on a batch of clouds, shape `[B, 3, N]` (with normals `[B, 6, N]`), as [`crate::preprocess`] makes them. Returns the
    /// features, shape `[B, F]`, row-major.
    ///
    /// # Errors
    /// The network failed.
    pub fn extract(&mut self, input: &[f32]) -> Result<Vec<f32>, ClassifyError> {
        let failed = |error: ort::Error| ClassifyError::Inference(error.to_string());
        let (columns, points) = (self.metadata.columns(), self.metadata.point_count);
        let clouds = input.len() / (columns * points).max(1);
        let clouds = TensorRef::from_array_view(([clouds, columns, points], input));
        let clouds = clouds.map_err(failed)?;
        let outputs = self.session.run(ort::inputs![INPUT_NAME => clouds]);
        let outputs = outputs.map_err(failed)?;
        let output = outputs.get(&self.output);
        let output = output
            .ok_or_else(|| ClassifyError::Inference(format!("there is no {}", self.output)))?;
        let (_, values) = output.try_extract_tensor::<f32>().map_err(failed)?;
        Ok(values.to_vec())
    }
}
