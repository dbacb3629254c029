//! Lays two scans of one object onto each other, between which it was put back into the hand another way.
//!
//! Nobody knows how it was turned, so that the second scan is tried upside down and upright, and from all sides. Each try
//! is corrected as a view is; the one that agrees best is kept. Only what a grasp should have shown is compared: what
//! the fingers cover, the underside, and what looks away from a camera that is a little above say nothing.
//!
//! Of an object with straight sides that was turned over, nothing tells how high it is: both ends are taken to have been
//! held equally deep.

mod pair;

use std::f64::consts::{PI, TAU};

use cloud::{Bounds, transformed};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use parameter::ParameterError;

use crate::error::RegistrationError;
use pair::{Agreement, Pair};

/// Starts about the hand's axis: half their step is what a correction can make good.
const TURNS: usize = 24;
/// Voxels of the search, and of the end, m.
const COARSE_M: f64 = 0.004;
const FINE_M: f64 = 0.002;
/// Upright must fit better than this share of the error of upside down, which is what people are asked for: a can looks
/// the same both ways, and a camera's errors are the more alike the more alike an object is held (half the mean square of
/// a spool in the simulated hand).
const UPRIGHT_BELOW: f64 = 0.3;
/// Share of the points at each end of an axis that may be strays.
const STRAYS: f64 = 0.01;

/// The least share of points that two scans of one object have in common: each hides what the fingers hold.
pub const FITNESS_MIN: f64 = 0.6;
/// The largest distance between two scans of one object where they agree, root mean square, m.
pub const RMSE_MAX_M: f64 = 0.002;

/// What every grasp hides of the object, in the hand's frame, +z out along the gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hidden {
    /// Height of the lowest points that are cropped to the object, m.
    pub below_m: f64,
    /// Height of the fingertips, m.
    pub fingertips_m: f64,
    /// Width of the fingers along x, m; they are at +y and -y.
    pub finger_width_m: f64,
}

/// How the object was put back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regrasp {
    /// Maps the second scan onto the first.
    pub first_from_second: Isometry3<f64>,
    /// Whether the end that was up is held in the second.
    pub upside_down: bool,
    /// Of the points of either scan that the other should show, the share with a neighbour there.
    pub fitness: f64,
    /// Root of the mean square of their distances, m.
    pub rmse_m: f64,
}

/// Two scans that are not laid onto each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegraspError {
    /// They do not agree, however the second is turned.
    #[error(
        "the two grasps show no common surface: at best {:.0} % of their points agree, to {:.1} mm (wanted {:.0} %, {:.1} mm); is it \
         the same object, undented meanwhile?",
        1e2 * .0.fitness, 1e3 * .0.rmse_m, 1e2 * FITNESS_MIN, 1e3 * RMSE_MAX_M
    )]
    Disagree(Regrasp),
    /// One of them cannot be registered at all.
    #[error(transparent)]
    Registration(#[from] RegistrationError),
    /// A parameter of registration.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// Finds how the second scan lies on the first; both in m, in the hand's frame, each cropped to the object.
///
/// # Errors
/// [`RegraspError`]: nothing agrees, or a scan is no surface.
pub fn regrasp(
    first: &[Point3<f32>],
    second: &[Point3<f32>],
    hidden: &Hidden,
) -> Result<Regrasp, RegraspError> {
    let coarse = Pair::new(first, second, COARSE_M, hidden)?;
    let fine = Pair::new(first, second, FINE_M, hidden)?;
    let best = |upside_down| -> Result<Agreement, RegistrationError> {
        let mut best: Option<(f64, Isometry3<f64>)> = None;
        for start in starts(first, second, upside_down) {
            let found = coarse.settle(start)?;
            let error_sq = coarse.agreement(&found).error_sq;
            if best.is_none_or(|(least_sq, _)| error_sq < least_sq) {
                best = Some((error_sq, found));
            }
        }
        let found = best.map_or_else(Isometry3::identity, |(_, found)| found);
        Ok(fine.agreement(&fine.settle(found)?))
    };
    let (over, upright) = (best(true)?, best(false)?);
    let upside_down = upright.error_sq >= UPRIGHT_BELOW * over.error_sq;
    let chosen = if upside_down { over } else { upright };
    let regrasp = Regrasp {
        first_from_second: chosen.first_from_second,
        upside_down,
        fitness: chosen.fitness,
        rmse_m: chosen.rmse_m,
    };
    if regrasp.fitness < FITNESS_MIN || regrasp.rmse_m > RMSE_MAX_M {
        return Err(RegraspError::Disagree(regrasp));
    }
    Ok(regrasp)
}

/// Poses of the second scan in which its box lies in that of the first, at its top or its bottom.
fn starts(
    first: &[Point3<f32>],
    second: &[Point3<f32>],
    upside_down: bool,
) -> impl Iterator<Item = Isometry3<f64>> {
    let target = bulk(first);
    let over = if upside_down { PI } else { 0.0 };
    (0..TURNS).flat_map(move |turn| {
        let turn_rad = TAU * turn as f64 / TURNS as f64;
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), over);
        let turned = transformed(
            &Isometry3::from_parts(Translation3::identity(), rotation),
            second,
        );
        let own = bulk(&turned);
        let across = target.centre() - own.centre();
        let heights = [target.max.z - own.max.z, target.min.z - own.min.z];
        heights.map(|height| {
            let shift = Vector3::new(across.x, across.y, height).cast::<f64>();
            Isometry3::from_parts(shift.into(), rotation)
        })
    })
}

/// The box around all but strays.
fn bulk(points: &[Point3<f32>]) -> Bounds {
    let mut bounds = Bounds {
        min: Point3::origin(),
        max: Point3::origin(),
    };
    let strays = (points.len() as f64 * STRAYS) as usize;
    for axis in 0..3 {
        let mut values: Vec<f32> = points.iter().map(|point| point[axis]).collect();
        values.sort_unstable_by(f32::total_cmp);
        if let (Some(min), Some(max)) = (values.get(strays), values.iter().rev().nth(strays)) {
            (bounds.min[axis], bounds.max[axis]) = (*min, *max);
        }
    }
    bounds
}
