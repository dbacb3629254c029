//! What lies beside a model so that it can be taught further objects: features of what it knows, and its self-test.

use std::path::Path;

use adaptation::{
    Block, FEATURES, FeatureRows, Head, KEPT_MAX, Kept, STRANGERS, features_path, with_features,
};
use anyhow::{Context, Result, ensure};
use classifier::{Extractor, Model, Provider, SelfTest, TestCloud, self_test_path};
use onnx_file::ModelBuilder;
use sim_dataset::digest::hex_digest;

use crate::data::LabelledClouds;
use crate::network::export::write_whole;

/// Scans of each label to fit layers with; half as many to check with.
pub const SCANS: usize = 120;
/// Clouds that the network sees at once.
const BATCH: usize = 64;

/// Writes the features of new clouds of everything that the model knows, and of strangers, with the self-test beside the
/// model. `clouds` are those to fit layers with, and those of other specimens to check with; the label after the last one
/// stands for strangers.
///
/// # Errors
/// The model cannot be read or is not the robot's network, a label has no cloud, or a file cannot be written.
pub fn write(model: &Path, clouds: &[LabelledClouds; 2], made: String) -> Result<()> {
    let bytes = std::fs::read(model).with_context(|| format!("cannot read {}", model.display()))?;
    let mut whole = Model::load(model, Provider::Cpu, "CPU")?;
    let metadata = whole.metadata().clone();
    let in_model = || format!("model {}", model.display());
    let builder = ModelBuilder::decode(&bytes).with_context(in_model)?;
    let width = Head::of(&builder).with_context(in_model)?.features();
    let with_features = with_features(&builder).with_context(in_model)?;
    let mut extractor = Extractor::new(&with_features, &metadata, FEATURES, model)?;
    let names = metadata.labels.iter().cloned().map(Some).chain([None]);
    let (mut blocks, mut candidates) = (Vec::new(), Vec::new());
    for (number, label) in names.enumerate() {
        let name = label.as_deref().unwrap_or("strangers");
        let [fit, check] = clouds
            .each_ref()
            .map(|part| inputs_of(part, number, metadata.metres_per_unit));
        ensure!(
            !fit.is_empty() && !check.is_empty(),
            "the camera sees too little of {name}, so that no features are kept for teach"
        );
        let times = if label.is_none() { STRANGERS } else { 1 };
        let mut rows = |inputs: &[Vec<f32>], most: usize| -> Result<FeatureRows> {
            let mut rows = FeatureRows::new(width);
            for batch in inputs.chunks(BATCH) {
                rows.push(&extractor.extract(&batch.concat())?);
            }
            Ok(rows.thinned(times * most))
        };
        if let Some(label) = &label {
            candidates.extend(check.iter().map(|input| TestCloud::of(label, input)));
        }
        blocks.push(Block {
            fit: rows(&fit, KEPT_MAX[0])?,
            check: rows(&check, KEPT_MAX[1])?,
            label,
        });
    }
    let kept = Kept {
        model: hex_digest(&bytes),
        made,
        width,
        blocks,
    };
    let self_test = SelfTest::of(&mut whole, &candidates)?;
    write_whole(&features_path(model), &kept.encode()?)?;
    write_whole(&self_test_path(model), &self_test.encode()?)
}

/// The network's input, `[3, N]` each, of the clouds with a label.
fn inputs_of(clouds: &LabelledClouds, label: usize, metres_per_unit: f64) -> Vec<Vec<f32>> {
    let units_per_metre = (1.0 / metres_per_unit) as f32;
    let own = (0..clouds.labels.len()).filter(|&index| clouds.labels[index] as usize == label);
    own.map(|index| {
        let cloud = clouds.cloud(index);
        let column = |column| cloud.iter().skip(column).step_by(clouds.columns);
        let values = (0..clouds.columns).flat_map(column);
        values.map(|value| value * units_per_metre).collect()
    })
    .collect()
}
