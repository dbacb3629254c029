//! Weights to begin with: those of a model that was trained before.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor};
use classifier::{Model, Provider};
use onnx_file::ModelBuilder;
use serde::{Deserialize, Serialize};
use sim_dataset::digest::hex_digest;

use crate::network::Network;

/// Name of the last layer, the only one whose shape depends on the number of classes: one output for each.
const LAST: &str = "head_2";

/// A model file whose weights training begins with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// The model file.
    pub model: PathBuf,
    /// SHA-256 of it, so that a run's name tells one model from another.
    pub sha256: String,
}

impl Start {
    /// The model file as it is now.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn of(model: &Path) -> Result<Self> {
        Ok(Self {
            model: model.to_path_buf(),
            sha256: hex_digest(&read(model)?),
        })
    }

    /// Sets the network's weights to the model's. The last layer's column of each label that the model does not know stays
    /// as it is.
    ///
    /// # Errors
    /// The file cannot be read, has changed, or is another network.
    pub fn put_into(&self, network: &Network, labels: &[String]) -> Result<()> {
        let path = self.model.display();
        let bytes = read(&self.model)?;
        ensure!(
            hex_digest(&bytes) == self.sha256,
            "{path} has changed meanwhile; start again"
        );
        let known = Model::load(&self.model, Provider::Cpu, "CPU")?;
        let known = &known.metadata().labels;
        let model = ModelBuilder::decode(&bytes).with_context(|| format!("model {path}"))?;
        for layer in network.layers() {
            for (kind, variable) in [("weight", &layer.weight), ("bias", &layer.bias)] {
                let name = format!("{}.{kind}", layer.name);
                let found = model.constant_f32_of(&name);
                let (shape, values) =
                    found.with_context(|| format!("{path} is another network: no {name}"))?;
                let set = if layer.name == LAST {
                    let before = variable.flatten_all()?.to_vec1::<f32>()?;
                    columns(before, labels, &values, known)
                } else {
                    (shape == variable.dims()).then_some(values)
                };
                let set = set
                    .filter(|set| set.len() == variable.elem_count())
                    .with_context(|| {
                        format!(
                            "{path} is another network: its {name} is {shape:?}, here it is {:?}",
                            variable.dims()
                        )
                    })?;
                variable.set(
                    &Tensor::from_vec(set, variable.dims(), &Device::Cpu)?
                        .to_device(variable.device())?,
                )?;
            }
        }
        Ok(())
    }
}

/// Row-major values with a column for each label: those of `known` from `from`.
fn columns(
    mut to: Vec<f32>,
    labels: &[String],
    from: &[f32],
    known: &[String],
) -> Option<Vec<f32>> {
    let rows = to.len() / labels.len();
    if from.len() != rows * known.len() {
        return None;
    }
    for (column, label) in labels.iter().enumerate() {
        if let Some(source) = known.iter().position(|name| name == label) {
            for row in 0..rows {
                to[row * labels.len() + column] = from[row * known.len() + source];
            }
        }
    }
    Some(to)
}

fn read(model: &Path) -> Result<Vec<u8>> {
    std::fs::read(model).with_context(|| format!("cannot read {}", model.display()))
}
