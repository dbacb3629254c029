//! Makes labelled clouds from many simulated scans.

use anyhow::Result;
use classifier::{Centring, ModelMetadata, preprocess};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_objects::ObjectClass;

use crate::samples::Samples;
use crate::scan::{full_view, scan};
use crate::scan_parameters::ScanParameters;
use crate::specimens::Labelled;

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

/// Clouds of all specimens, made on all cores: of each the whole surface, and what a scan gives after each view.
/// `finished` is called after each specimen.
///
/// The same arguments give the same clouds in the same order.
///
/// # Errors
/// A specimen cannot be made, or settings that a node refuses.
pub fn simulate(
    labelled: &[Labelled],
    parameters: &ScanParameters,
    metadata: &ModelMetadata,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<Samples> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let specimens: Vec<(&Labelled, u64)> = labelled
        .iter()
        .flat_map(|labelled| (0..labelled.count).map(move |_| labelled))
        .map(|labelled| (labelled, random.random()))
        .collect();
    let parts: Vec<Result<Samples>> = specimens
        .into_par_iter()
        .map(|(labelled, seed)| {
            let samples = specimen_samples(labelled, parameters, metadata, seed);
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
    labelled: &Labelled,
    parameters: &ScanParameters,
    metadata: &ModelMetadata,
    seed: u64,
) -> Result<Samples> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let object = labelled.specimens.one(parameters, &mut random)?;
    let mut seen = vec![full_view(&object, &mut random)];
    seen.extend(scan(&object, parameters, random.random())?);
    let mut samples = Samples::new(metadata.point_count);
    for object in seen {
        // An object that is hardly in view has no answer on the robot either.
        if let Ok(input) = preprocess(&object.points, &object.up, metadata) {
            samples.push_input(&input, metadata.metres_per_unit, labelled.label, &object);
        }
    }
    Ok(samples)
}
