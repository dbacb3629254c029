//! The network answers alike in the training framework, in ONNX Runtime and in OpenVINO.
#![allow(clippy::unwrap_used)]

use candle_core::{Device, Tensor};
use candle_nn::ops::log_softmax;
use classifier::{Centring, Model, Provider};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use training::dataset::preprocessing;
use training::export::write_model;
use training::network::{Architecture, Network};

const SEED: u64 = 20;
const INVERSE_TEMPERATURE: f64 = 0.7;
const CLOUDS: usize = 200;

/// A network whose transformer, too, is not what it starts as.
fn random_network(random: &mut Pcg64Mcg, classes: usize) -> Network {
    let network = Network::robot(Architecture::default(), classes, random).unwrap();
    for variable in network.variables() {
        let count = variable.elem_count();
        let noise: Vec<f32> = (0..count)
            .map(|_| random.random_range(-0.005..0.005))
            .collect();
        let noise = Tensor::from_vec(noise, variable.shape(), &Device::Cpu).unwrap();
        variable
            .set(&(variable.as_tensor() + noise).unwrap())
            .unwrap();
    }
    network
}

#[test]
fn candle_onnx_runtime_and_openvino_agree() {
    println!("seed {SEED}");
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let metadata = preprocessing(128, Centring::Box);
    let network = random_network(&mut random, metadata.labels.len());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.onnx");
    write_model(&path, &network, INVERSE_TEMPERATURE, &metadata).unwrap();
    let mut models = [Provider::Cpu, Provider::OpenVino].map(|provider| {
        let model = Model::load(&path, provider, "CPU").unwrap();
        assert_eq!(model.fallback_reason(), None);
        model
    });
    for _ in 0..CLOUDS {
        let input: Vec<f32> = (0..3 * 128)
            .map(|_| random.random_range(-1.0..1.0))
            .collect();
        let cloud = Tensor::from_slice(&input, (1, 3, 128), &Device::Cpu).unwrap();
        let cloud = cloud.transpose(1, 2).unwrap().contiguous().unwrap();
        let logits = network.logits(&cloud).unwrap();
        let known_score = logits.log_sum_exp(1).unwrap().to_vec1::<f32>().unwrap();
        let tempered = (logits * INVERSE_TEMPERATURE).unwrap();
        let log_probabilities = log_softmax(&tempered, 1).unwrap();
        let expected = log_probabilities
            .squeeze(0)
            .unwrap()
            .to_vec1::<f32>()
            .unwrap();
        let expected = [expected, known_score].concat();
        for model in &mut models {
            let found = model.infer(&input).unwrap();
            let found = [found.log_probabilities, vec![found.known_score]].concat();
            assert_eq!(found.len(), expected.len());
            for (a, b) in expected.iter().zip(&found) {
                assert!(
                    (a - b).abs() < 1e-4 * a.abs().max(1.0),
                    "{}: {found:?}, not {expected:?}",
                    model.provider()
                );
            }
        }
    }
}
