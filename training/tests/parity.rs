//! The networks answer alike in the training framework, in ONNX Runtime and in OpenVINO.
#![allow(clippy::unwrap_used)]

#[path = "common/networks.rs"]
mod networks;

use classifier::{MAX_MODEL_BYTES, Model, Provider};
use networks::{CLOUDS, SEED, answers, examples, inputs};
use training::export::write_model;

#[test]
fn candle_onnx_runtime_and_openvino_agree() {
    println!("seed {SEED}");
    let folder = tempfile::tempdir().unwrap();
    for (name, network, metadata) in examples().unwrap() {
        let path = folder.path().join(format!("{name}.onnx"));
        let bytes = write_model(&path, &network, &metadata).unwrap();
        assert!(bytes <= MAX_MODEL_BYTES);
        let inputs = inputs(&metadata).unwrap();
        let expected = answers(&network, &inputs)
            .unwrap()
            .to_vec2::<f32>()
            .unwrap();
        let inputs = inputs.flatten_from(1).unwrap().to_vec2::<f32>().unwrap();
        for provider in [Provider::Cpu, Provider::OpenVino] {
            let mut model = Model::load(&path, provider, "CPU").unwrap();
            assert_eq!(model.fallback_reason(), None);
            let mut largest = 0.0f32;
            for (input, expected) in inputs.iter().zip(&expected) {
                let found = model.infer(input).unwrap();
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
