//! The networks answer alike in the training framework, in ONNX Runtime and in OpenVINO.
#![allow(clippy::unwrap_used)]

#[path = "common/networks.rs"]
mod networks;

use candle_core::Tensor;
use classifier::{MAX_MODEL_BYTES, Model, Provider};
use networks::{CLOUDS, INVERSE_TEMPERATURE, SEED, answers, examples, inputs};
use training::network::export::write_model;

#[test]
fn candle_onnx_runtime_and_openvino_agree() {
    println!("seed {SEED}");
    let folder = tempfile::tempdir().unwrap();
    for (name, network, metadata) in examples().unwrap() {
        let path = folder.path().join(format!("{name}.onnx"));
        let bytes = write_model(&path, &network, INVERSE_TEMPERATURE, &metadata).unwrap();
        assert!(bytes <= MAX_MODEL_BYTES);
        let inputs = inputs(&metadata).unwrap();
        let (log_probabilities, known_scores) = answers(&network, &inputs).unwrap();
        let expected = Tensor::cat(&[log_probabilities, known_scores.unsqueeze(1).unwrap()], 1);
        let expected = expected.unwrap().to_vec2::<f32>().unwrap();
        let inputs = inputs.flatten_from(1).unwrap().to_vec2::<f32>().unwrap();
        for provider in [Provider::Cpu, Provider::OpenVino] {
            let mut model = Model::load(&path, provider, "CPU").unwrap();
            assert_eq!(model.fallback_reason(), None);
            let mut largest = 0.0f32;
            for (input, expected) in inputs.iter().zip(&expected) {
                let found = model.infer(input).unwrap();
                let found = [found.log_probabilities, vec![found.known_score]].concat();
                assert_eq!(found.len(), expected.len());
                // Of an untrained network: some log-probabilities are far below those that matter.
                let difference = |(a, b): (&f32, &f32)| (a - b).abs() / a.abs().max(1.0);
                let differences = expected.iter().zip(&found).map(difference);
                largest = differences.fold(largest, f32::max);
            }
            let provider = model.provider();
            println!("{name}, {provider}: {CLOUDS} clouds, largest difference {largest:.1e}");
            assert!(largest < 1e-4, "{name}, {provider}: {largest}");
        }
    }
}
