//! Writes models of random networks, clouds, and what the training framework answers to them, for tests/peers/model.

#[path = "../tests/common/networks.rs"]
mod networks;

use std::path::PathBuf;

use anyhow::{Context, Result};
use candle_core::Tensor;
use networks::{INVERSE_TEMPERATURE, answers, examples, inputs};
use training::network::export::write_model;

fn main() -> Result<()> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.context("name a folder")?;
    for (name, network, metadata) in examples()? {
        let model = folder.join(format!("{name}.onnx"));
        write_model(&model, &network, INVERSE_TEMPERATURE, &metadata)?;
        let points = inputs(&metadata)?;
        let (log_probabilities, known_score) = answers(&network, &points)?;
        let arrays = [
            ("points", points),
            ("log_probabilities", log_probabilities),
            ("known_score", known_score),
        ];
        Tensor::write_npz(&arrays, folder.join(format!("{name}.npz")))?;
    }
    Ok(())
}
