//! Makes labelled clouds from many simulated scans.

use anyhow::Result;
use classifier::{Centring, KnownBy, ModelMetadata, preprocess};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_objects::ObjectClass;
use sim_scan::{ScanParameters, ScannedObject, full_view, scan};

use super::clouds::{LabelledClouds, Seen, Split};
use super::specimens::Labelled;

/// Preprocessing of clouds for the network: the part of the model's metadata that is known before training.
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
        known_by: KnownBy::Network,
        trained_on: None,
    }
}

/// Preprocessed clouds of all specimens: for each specimen the whole surface, and the fused cloud of a scan after each view.
/// `finished` is called after each specimen.
///
/// # Errors
/// As [`see_all`].
pub fn simulate(
    labelled: &[Labelled],
    split: Split,
    parameters: &ScanParameters,
    metadata: &ModelMetadata,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<LabelledClouds> {
    // Preprocessing refuses a cloud with too few points; the robot gives no answer for it either.
    let take = |object: &ScannedObject| preprocess(&object.points, &object.up, metadata).ok();
    let mut clouds = LabelledClouds::new(metadata.point_count, metadata.columns());
    for seen in see_all(labelled, parameters, seed, take, finished)? {
        clouds.push(&seen, metadata.metres_per_unit, split);
    }
    Ok(clouds)
}

/// Applies `take` to the clouds of all specimens and returns the results with their labels: for each specimen the whole
/// surface, and the fused cloud of a scan after each view. Runs on all cores; the clouds themselves are dropped.
///
/// The same arguments give the same results in the same order.
///
/// # Errors
/// A specimen cannot be made, or settings that a node refuses.
pub fn see_all<T: Send>(
    labelled: &[Labelled],
    parameters: &ScanParameters,
    seed: u64,
    take: impl Fn(&ScannedObject) -> Option<T> + Sync,
    finished: impl Fn() + Sync,
) -> Result<Vec<Seen<T>>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let specimens: Vec<(&Labelled, u64)> = labelled
        .iter()
        .flat_map(|labelled| (0..labelled.count).map(move |_| labelled))
        .map(|labelled| (labelled, random.random()))
        .collect();
    let see = |(labelled, seed): (&Labelled, u64)| -> Result<Vec<Seen<T>>> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let object = labelled.specimens.one(parameters, &mut random)?;
        let mut views = vec![full_view(&object, &mut random)];
        views.extend(scan(&object, parameters, random.random())?);
        let seen = views.iter().filter_map(|view| {
            take(view).map(|taken| Seen {
                label: labelled.label,
                view_count: view.view_count as u32,
                held: view.held,
                taken,
            })
        });
        let seen = seen.collect();
        finished();
        Ok(seen)
    };
    let parts: Vec<Result<Vec<Seen<T>>>> = specimens.into_par_iter().map(see).collect();
    let mut all = Vec::new();
    for part in parts {
        all.extend(part?);
    }
    Ok(all)
}
