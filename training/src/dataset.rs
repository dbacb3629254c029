//! Makes labelled clouds from many simulated scans.

use anyhow::Result;
use classifier::{Centring, ModelMetadata, preprocess};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_objects::ObjectClass;

use crate::samples::Samples;
use crate::scan::scan_specimen;
use crate::scan_parameters::ScanParameters;

/// How clouds are made ready for the network; the part of the model's metadata that is known before training.
pub fn preprocessing(point_count: usize, centring: Centring) -> ModelMetadata {
    ModelMetadata {
        labels: ObjectClass::ALL
            .map(|class| class.name().to_owned())
            .to_vec(),
        point_count,
        metres_per_unit: 0.1,
        centring,
        normals: false,
        network_version: crate::network::NETWORK_VERSION.to_owned(),
        run_id: "none".to_owned(),
        known_threshold: 0.0,
    }
}

/// Scans `specimens_per_class` specimens of each class, on all cores. `finished` is called after each specimen.
///
/// The same arguments give the same clouds in the same order.
///
/// # Errors
/// Settings that a node refuses.
pub fn simulate(
    specimens_per_class: usize,
    parameters: &ScanParameters,
    metadata: &ModelMetadata,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<Samples> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let classes = ObjectClass::ALL.into_iter().enumerate();
    let specimens: Vec<(usize, ObjectClass, u64)> = classes
        .flat_map(|(label, class)| (0..specimens_per_class).map(move |_| (label, class)))
        .map(|(label, class)| (label, class, random.random()))
        .collect();
    let parts: Vec<Result<Samples>> = specimens
        .into_par_iter()
        .map(|(label, class, seed)| {
            let samples = specimen_samples(label as u32, class, parameters, metadata, seed);
            finished();
            samples
        })
        .collect();
    let mut all = Samples::new(metadata.point_count);
    for part in parts {
        all.append(part?);
    }
    Ok(all)
}

fn specimen_samples(
    label: u32,
    class: ObjectClass,
    parameters: &ScanParameters,
    metadata: &ModelMetadata,
    seed: u64,
) -> Result<Samples> {
    let mut samples = Samples::new(metadata.point_count);
    for object in scan_specimen(class, parameters, seed)? {
        // An object that is hardly in view has no answer on the robot either.
        if let Ok(input) = preprocess(&object.points, &object.up, metadata) {
            samples.push_input(&input, metadata.metres_per_unit, label, &object);
        }
    }
    Ok(samples)
}
