//! The scans that are measured, and the figures made of them.
#![allow(clippy::unwrap_used, dead_code)] // Each test file uses a part.

use std::path::Path;

use classifier::{Model, Provider};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sim_objects::ObjectClass;
use sim_scan::{ScanParameters, Setup, dented};

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/model.onnx");

/// How many scans are to be measured, and the seed of the first one: `SCANS` and `SEED`, or these.
pub fn asked(scans: usize, first_seed: u64) -> (usize, u64) {
    let number = |name, default| std::env::var(name).map_or(default, |text| text.parse().unwrap());
    (
        number("SCANS", scans as u64) as usize,
        number("SEED", first_seed),
    )
}

/// The shipped model.
pub fn model() -> Model {
    Model::load(Path::new(MODEL), Provider::Cpu, "CPU").unwrap()
}

/// A dented object in the hand before the camera. The random numbers go on from there.
pub fn held(seed: u64) -> (ObjectClass, Setup, Pcg64Mcg) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let parameters = ScanParameters {
        table_share: 0.0,
        undented_share: 0.0,
        ..ScanParameters::default()
    };
    let class = ObjectClass::ALL[seed as usize % ObjectClass::ALL.len()];
    let object = dented(class, &parameters, &mut random).unwrap();
    let setup = Setup::random(&object, &parameters, &mut random);
    (class, setup, random)
}

/// Mean, and half of its 95 % confidence interval.
pub fn mean(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = |value: &f64| (value - mean).powi(2);
    let variance = values.iter().map(square).sum::<f64>() / (count - 1.0);
    (mean, 1.96 * (variance / count).sqrt())
}
