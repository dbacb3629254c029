//! What the two ways of laying a view onto the model share.

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};

use crate::observability::Certainty;

/// Where a view came to lie.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Alignment {
    pub(crate) motion: Isometry3<f64>,
    pub(crate) fit: Fit,
    pub(crate) iterations: usize,
    pub(crate) converged: bool,
    pub(crate) degenerate_directions: usize,
    /// Of a start by kinematics only.
    pub(crate) certainty: Option<Certainty>,
}

/// How well it lies there.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Fit {
    /// Share of the points with a neighbour within the matching distance.
    pub(crate) fitness: f64,
    /// Root of the mean square of their distances, m.
    pub(crate) rmse_m: f64,
    /// Their number.
    pub(crate) inliers: usize,
}

impl Fit {
    pub(crate) fn new(inliers: usize, count: usize, sum_sq: f64) -> Self {
        let share = |sum: f64, of: usize| if of == 0 { 0.0 } else { sum / of as f64 };
        Self {
            fitness: share(inliers as f64, count),
            rmse_m: share(sum_sq, inliers).sqrt(),
            inliers,
        }
    }
}

/// A motion in the form that is quickest to apply.
pub(crate) struct Placed {
    rotation: Rotation3<f32>,
    translation: Vector3<f32>,
}

impl Placed {
    pub(crate) fn by(motion: &Isometry3<f64>) -> Self {
        let motion: Isometry3<f32> = motion.cast();
        Self {
            rotation: motion.rotation.to_rotation_matrix(),
            translation: motion.translation.vector,
        }
    }

    pub(crate) fn place(&self, point: &Point3<f32>) -> Point3<f32> {
        self.rotation * point + self.translation
    }
}
