//! Accepts what the search for a view's place found, or says why not.

use nalgebra::{Isometry3, Point3};

use crate::align::Alignment;
use crate::evidence::{StopReason, ViewEvidence};
use crate::parameters::Parameters;
use crate::visibility::Comparison;

/// The evidence of a view whose matched points (m) the search moved from `start`. The bounds of a correction hold where
/// kinematics gave the start.
pub(crate) fn judge(
    sample: &[Point3<f32>],
    start: Isometry3<f64>,
    alignment: &Alignment,
    is_kinematic: bool,
    limits: &Parameters,
) -> ViewEvidence {
    let middle = cloud::centroid(sample).unwrap_or_else(Point3::origin);
    let middle: Point3<f64> = middle.cast();
    let correction_m = (alignment.motion * middle - middle).norm();
    let correction_rad = alignment.motion.rotation.angle();
    let bounds = || is_kinematic.then(|| too_far(correction_m, correction_rad, limits))?;
    let reason = too_poor(alignment, limits).or_else(bounds);
    let stop_reason = match (&reason, alignment.converged) {
        (Some(_), _) => StopReason::Refused,
        (None, true) => StopReason::Converged,
        (None, false) => StopReason::IterationLimit,
    };
    ViewEvidence {
        transform: alignment.motion * start,
        accepted: reason.is_none(),
        reason: reason.unwrap_or_default(),
        stop_reason,
        fitness: alignment.fit.fitness,
        rmse_m: alignment.fit.rmse_m,
        inliers: alignment.fit.inliers,
        iterations: alignment.iterations,
        correction_m,
        correction_rad,
        degenerate_directions: alignment.degenerate_directions,
        comparison: Comparison::default(),
    }
}

fn too_poor(alignment: &Alignment, limits: &Parameters) -> Option<String> {
    let (fitness, min_fitness) = (alignment.fit.fitness, limits.min_fitness);
    (fitness < min_fitness).then(|| {
        format!("only a share of {fitness:.2} of its points fits, below min_fitness {min_fitness}")
    })
}

fn too_far(correction_m: f64, correction_rad: f64, limits: &Parameters) -> Option<String> {
    if correction_m > limits.max_correction_m {
        let (moved_mm, limit_mm) = (1e3 * correction_m, 1e3 * limits.max_correction_m);
        return Some(format!(
            "it would be moved by {moved_mm:.1} mm, max_correction_m allows {limit_mm:.1} mm; did the \
             object slip, or is the camera mount off?"
        ));
    }
    if correction_rad > limits.max_correction_rad {
        let (turned, limit) = (
            correction_rad.to_degrees(),
            limits.max_correction_rad.to_degrees(),
        );
        return Some(format!(
            "it would be turned by {turned:.1}°, max_correction_rad allows {limit:.1}°; did the \
             object slip, or is the camera mount off?"
        ));
    }
    None
}
