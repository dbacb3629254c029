//! A model file alone.

use std::path::{Path, PathBuf};

use adaptation::{FEATURES, Head, inverse_temperature_of, with_features};
use anyhow::{Context, Result};
use classifier::{Extractor, Features, Model, ModelMetadata, Provider};
use onnx_file::ModelBuilder;
use sim_dataset::digest::hex_digest;

/// A model without its features.
#[derive(Debug, Clone)]
pub struct Unprepared {
    /// Its file.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub digest: String,
    /// What the file says about itself.
    pub metadata: ModelMetadata,
    /// The layers that can be fitted again.
    pub head: Head,
    pub(crate) bytes: Vec<u8>,
    pub(crate) builder: ModelBuilder,
}

impl Unprepared {
    /// Reads a model.
    ///
    /// # Errors
    /// The model cannot be used, or is not the robot's network.
    pub fn open(path: &Path) -> Result<Self> {
        let network = Model::load_with(path, Features::Unused, Provider::Cpu, "CPU")?;
        let metadata = network.metadata().clone();
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let in_model = || format!("model {}", path.display());
        let builder = ModelBuilder::decode(&bytes).with_context(in_model)?;
        Ok(Self {
            head: Head::of(&builder).with_context(in_model)?,
            path: path.to_path_buf(),
            digest: hex_digest(&bytes),
            metadata,
            bytes,
            builder,
        })
    }

    /// What computes features of clouds.
    ///
    /// # Errors
    /// ONNX Runtime refuses the network.
    pub fn extractor(&self) -> Result<Extractor> {
        extractor(&self.builder, &self.metadata, &self.path)
    }

    /// 1/T of the probabilities.
    ///
    /// # Errors
    /// The network has none.
    pub fn inverse_temperature(&self) -> Result<f64> {
        Ok(inverse_temperature_of(&self.builder)?)
    }
}

pub(crate) fn extractor(
    model: &ModelBuilder,
    metadata: &ModelMetadata,
    path: &Path,
) -> Result<Extractor> {
    let bytes = with_features(model)?;
    Ok(Extractor::new(&bytes, metadata, FEATURES, path)?)
}
