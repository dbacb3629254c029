//! From a scan to dented specimens of the object.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use mesh::Mesh;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_dataset::object::{Object, Source};
use sim_dataset::settings::Settings;
use sim_deform::DentError;
use sim_deform::grasp::Grasp;

use crate::look::Watch;

/// Fewer places to press leave nothing to check with, or nothing to measure on.
pub const GRASPS_MIN: usize = 4;
/// Share of specimens without a dent, as in training.
const UNDENTED_SHARE: f64 = 0.2;

/// How many specimens are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts {
    /// Places where a gripper presses, each to six depths: half of them to learn from, a quarter each to check with and to
    /// measure on.
    pub grasps: usize,
    /// Simulated scans to learn from; half as many to check with, and as many to measure on.
    pub scans: usize,
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            grasps: 32,
            scans: 160,
        }
    }
}

/// Specimens of an object, each group pressed elsewhere.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Specimens {
    /// To fit layers with.
    pub fit: Vec<Mesh>,
    /// To find temperature and threshold with.
    pub check: Vec<Mesh>,
    /// To measure on.
    pub test: Vec<Mesh>,
}

/// Whether a name can be a label.
///
/// # Errors
/// It cannot; with what may be in one.
pub fn check_label(label: &str) -> Result<()> {
    // The rules are those of datasets.
    let source = Source::Scan {
        file: format!("{label}.ply").into(),
        metres_per_unit: 1.0,
    };
    ensure!(
        source.name().is_ok_and(|name| name == label),
        "{label:?} cannot name an object; use letters, digits, - and _"
    );
    Ok(())
}

/// Makes a mesh of a scan that can be dented.
///
/// # Errors
/// The file cannot be read, no sound mesh comes of it, or the object does not go into hand or crop.
pub fn load(label: &str, scan: &Path, metres_per_unit: f64) -> Result<Object> {
    check_label(label)?;
    let source = Source::Scan {
        file: scan.to_path_buf(),
        metres_per_unit,
    };
    let object = source.load(&Settings::default())?;
    check_size(label, object.denter.source())?;
    Ok(object)
}

/// Refuses what the crop would cut off.
fn check_size(label: &str, mesh: &Mesh) -> Result<()> {
    let crop = roi_crop::Parameters::default();
    let mesh = mesh.stood_up();
    let height_m = f64::from(mesh.bounds().1.z);
    let aside = mesh.vertices.iter().map(|v| f64::from(v.x.hypot(v.y)));
    let radius_m = aside.fold(0.0, f64::max);
    for (what, size_m, most_m, parameter) in [
        ("high", height_m, crop.height_m, "height_m"),
        (
            "from its axis to its edge",
            radius_m,
            crop.radius_m,
            "radius_m",
        ),
    ] {
        ensure!(
            size_m <= most_m,
            "{label} is {:.0} mm {what}, and {:.0} mm are cut out of the camera's view (roi_crop/{parameter}): \
             is it in millimetres and +z up (--units)?",
            1e3 * size_m,
            1e3 * most_m
        );
    }
    Ok(())
}

/// Extents of an object: width, depth and height, m.
pub fn extents_m(mesh: &Mesh) -> [f32; 3] {
    let (min, max) = mesh.bounds();
    (max - min).into()
}

/// Presses an object in many ways.
///
/// # Errors
/// The gripper finds too few places, or the user wants an end.
pub fn specimens(object: &Object, counts: Counts, seed: u64, watch: &Watch) -> Result<Specimens> {
    let grasps = grasps(object, counts.grasps, seed)?;
    let intensities_m = Settings::default().intensities_m;
    let dent = |grasp: &Grasp| -> Result<Vec<Mesh>> {
        watch.go_on()?;
        let dents = match object.denter.dent(grasp, &intensities_m) {
            Ok(dents) => dents,
            // Where the surface folds, there is no dent.
            Err(DentError::Folds { .. }) => Vec::new(),
            Err(error) => return Err(error.into()),
        };
        (watch.finished)();
        Ok(dents.into_iter().map(|dent| dent.mesh.stood_up()).collect())
    };
    let dented: Vec<Result<Vec<Mesh>>> = grasps.par_iter().map(dent).collect();
    let dented: Vec<Vec<Mesh>> = dented.into_iter().collect::<Result<_>>()?;
    let quarter = dented.len() / 4;
    let (test, others) = dented.split_at(quarter);
    let (check, fit) = others.split_at(quarter);
    let undented = object.denter.source().stood_up();
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut drawn = |groups: &[Vec<Mesh>], count: usize| -> Result<Vec<Mesh>> {
        let dented: Vec<&Mesh> = groups.iter().flatten().collect();
        let mut drawn = Vec::with_capacity(count);
        for _ in 0..count {
            drawn.push(match dented.choose(&mut random) {
                Some(_) if random.random_bool(UNDENTED_SHARE) => undented.clone(),
                Some(dented) => (*dented).clone(),
                None => bail!("{} folds wherever the gripper presses it", object.name),
            });
        }
        Ok(drawn)
    };
    Ok(Specimens {
        fit: drawn(fit, counts.scans)?,
        check: drawn(check, counts.scans.div_ceil(2))?,
        test: drawn(test, counts.scans)?,
    })
}

/// Places where the gripper can press.
fn grasps(object: &Object, count: usize, seed: u64) -> Result<Vec<Grasp>> {
    let all = object.denter.grasps();
    let mut found = Vec::with_capacity(count);
    let mut refusal = None;
    for handle in all.order(seed) {
        if found.len() == count {
            break;
        }
        match all.grasp(handle) {
            Ok(grasp) => found.push(grasp),
            Err(refused) => refusal = Some(refused),
        }
    }
    if found.len() < GRASPS_MIN.min(count) {
        let reason = refusal
            .map(|reason| format!(" ({reason})"))
            .unwrap_or_default();
        bail!(
            "the gripper can press {} in {} places, and {GRASPS_MIN} are needed{reason}: is it in millimetres (--units), \
             and does it go between the fingers?",
            object.name,
            found.len()
        );
    }
    Ok(found)
}
