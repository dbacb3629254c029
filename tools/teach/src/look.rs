//! Simulated views of an object, as the classifier would get them.

use std::sync::atomic::{AtomicBool, Ordering};

use adaptation::FeatureRows;
use anyhow::{Result, ensure};
use classifier::{Extractor, ModelMetadata, preprocess, preprocess_parts};
use mesh::Mesh;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_scan::{ScanParameters, ScannedObject, full_view, scan};

/// Clouds that the network sees at once.
const BATCH: usize = 64;
/// Views of a scan that is measured on.
pub const VIEWS: usize = 3;

/// Whom to tell of each finished specimen, and whether to go on.
pub struct Watch<'a> {
    /// Called after each one.
    pub finished: &'a (dyn Fn() + Sync),
    /// True once the user wants an end.
    pub stop: &'a AtomicBool,
}

impl Watch<'_> {
    /// An error once the user wants an end.
    ///
    /// # Errors
    /// Then.
    pub fn go_on(&self) -> Result<()> {
        ensure!(
            !self.stop.load(Ordering::Relaxed),
            "stopped; nothing has changed"
        );
        Ok(())
    }
}

/// The network's input of the whole surface of each specimen, and of its cloud after each view of a scan: some in the hand,
/// some on a box, as in training. One sample a cloud, `[3, N]` each.
///
/// # Errors
/// A scan cannot be simulated, or the user wants an end.
pub fn to_learn(
    specimens: &[Mesh],
    metadata: &ModelMetadata,
    seed: u64,
    watch: &Watch,
) -> Result<Vec<Vec<f32>>> {
    let parameters = ScanParameters::default();
    let clouds = of_each(specimens, seed, watch, |mesh, random| {
        let mut views = vec![full_view(mesh, random)];
        views.extend(scan(mesh, &parameters, random.random())?);
        Ok(views)
    })?;
    let input = |seen: &ScannedObject| preprocess(&seen.points, &seen.up, metadata).ok();
    Ok(clouds.par_iter().filter_map(input).collect())
}

/// The network's input of scans of three views in the hand, as the robot makes it: up to four samples of a cloud. A specimen
/// whose cloud the nodes refuse has none.
///
/// # Errors
/// As [`to_learn`].
pub fn to_measure(
    specimens: &[Mesh],
    metadata: &ModelMetadata,
    seed: u64,
    watch: &Watch,
) -> Result<Vec<Vec<f32>>> {
    let parameters = ScanParameters {
        view_count: VIEWS,
        table_share: 0.0,
        ..ScanParameters::default()
    };
    let clouds = of_each(specimens, seed, watch, |mesh, random| {
        let views = scan(mesh, &parameters, random.random())?;
        let whole = views.into_iter().find(|view| view.view_count == VIEWS);
        Ok(whole.into_iter().collect())
    })?;
    let input = |seen: &ScannedObject| preprocess_parts(&seen.points, &seen.up, metadata).ok();
    Ok(clouds.par_iter().filter_map(input).collect())
}

fn of_each(
    specimens: &[Mesh],
    seed: u64,
    watch: &Watch,
    see: impl Fn(&Mesh, &mut Pcg64Mcg) -> Result<Vec<ScannedObject>> + Sync,
) -> Result<Vec<ScannedObject>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let seeded: Vec<(&Mesh, u64)> = specimens
        .iter()
        .map(|mesh| (mesh, random.random()))
        .collect();
    let seen: Vec<Result<Vec<ScannedObject>>> = seeded
        .into_par_iter()
        .map(|(mesh, seed)| {
            watch.go_on()?;
            let seen = see(mesh, &mut Pcg64Mcg::seed_from_u64(seed));
            (watch.finished)();
            seen
        })
        .collect();
    let mut all = Vec::new();
    for seen in seen {
        all.extend(seen?);
    }
    Ok(all)
}

/// The features of each input of one sample.
///
/// # Errors
/// The network failed.
pub fn features(
    inputs: &[Vec<f32>],
    extractor: &mut Extractor,
    width: usize,
) -> Result<FeatureRows> {
    let mut rows = FeatureRows::new(width);
    for batch in inputs.chunks(BATCH) {
        rows.push(&extractor.extract(&batch.concat())?);
    }
    Ok(rows)
}

/// The features of all samples of each input.
///
/// # Errors
/// The network failed.
pub fn features_of_samples(
    inputs: &[Vec<f32>],
    extractor: &mut Extractor,
    width: usize,
) -> Result<Vec<FeatureRows>> {
    let mut of = |input: &Vec<f32>| {
        let mut rows = FeatureRows::new(width);
        rows.push(&extractor.extract(input)?);
        Ok(rows)
    };
    inputs.iter().map(&mut of).collect()
}
