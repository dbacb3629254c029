//! Calibrates the camera mount from views of the turning wrist.
//!
//! While the wrist turns, gripper and object stay one rigid body. If the mount is wrong by a motion X, kinematics do not
//! align the views of that body; X is the motion that aligns them. With A the camera's motion between two views by
//! kinematics and B the motion seen, A X = X B (Shiu & Ahmad 1989). Here B is not estimated first: X itself is fitted to the
//! surfaces of all pairs of views at once, by point-to-plane distances.
//!
//! A single axis leaves two motions open: a camera rotated about the wrist's axis, or shifted along it, sees the same. A
//! second sweep with the arm in another pose determines these, too.

mod equations;
mod surface;

pub use hand_eye::turn_and_shift;
use hand_eye::{motion, prior_sigmas};
use nalgebra::{Isometry3, Matrix6, Point3, Vector3, Vector6};

use equations::Equations;
use surface::Surface;

/// The camera's cloud at one wrist angle.
#[derive(Debug, Clone)]
pub struct View {
    /// hand_from_camera by kinematics and the present mount.
    pub hand_from_camera: Isometry3<f64>,
    /// Points in the camera's frame, m.
    pub points: Vec<Point3<f32>>,
}

/// The mount's error and its uncertainty. Rotations and translations are in the camera's frame.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// X: maps from the actual camera's frame to the frame that the present mount gives.
    pub believed_from_actual: Isometry3<f64>,
    /// Covariance of X: three rotations (rad), three translations (m), in the actual camera's frame.
    pub covariance: Matrix6<f64>,
    /// Motions that the sweeps do not determine, as rotation vector (rad) and translation (m), scaled to one standard
    /// deviation. In these directions X is only the prior.
    pub open: Vec<Vector6<f64>>,
    /// Root mean square distance between the surfaces of two views with the present mount, m.
    pub before_m: f64,
    /// The same after correction by X, m.
    pub after_m: f64,
}

/// Why there is no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// A sweep of fewer than two views.
    #[error("a sweep needs two views or more, and has {count}")]
    TooFewViews {
        /// Its views.
        count: usize,
    },
    /// A view with too few points of gripper and object.
    #[error(
        "view {number} shows {count} points of gripper and object, {needed} are needed; is the hand in front of the camera?"
    )]
    TooFewPoints {
        /// Number of the view among all, from 1.
        number: usize,
        /// Number of its points.
        count: usize,
        /// Number of points needed.
        needed: usize,
    },
    /// Views without a common surface.
    #[error(
        "the views have no surface in common (only {count} pairs of points): turn the wrist in smaller steps, or measure the mount to {reach_mm:.0} mm first"
    )]
    NothingInCommon {
        /// Number of pairs of points found.
        count: usize,
        /// Largest distance at which points are matched, mm.
        reach_mm: f64,
    },
    /// No motion of the mount aligns the views.
    #[error(
        "the views do not agree: only {share_percent:.0} % of the surfaces lie on each other, {needed_percent:.0} % are needed; did the object move in the fingers?"
    )]
    Disagreement {
        /// Share of the surfaces that agree, percent.
        share_percent: f64,
        /// Share that must agree, percent.
        needed_percent: f64,
    },
}

/// Coarse to fine: (largest distance at which points are matched, m; number of iterations).
const SEARCH: [(f32, usize); 4] = [(0.020, 8), (0.010, 6), (0.005, 6), (0.003, 10)];
/// Least number of pairs of points for a calibration.
const PAIRS_MIN: usize = 500;
/// Least share of the matched surfaces that must agree.
const AGREEING_MIN: f64 = 0.75;
/// A motion counts as open if its standard deviation is more than this share of the prior's.
const OPEN_ABOVE: f64 = 0.15;

/// Estimates the mount's error that aligns the views of each sweep best. Views of different sweeps are not compared, because
/// the object may have been grasped anew in between.
///
/// # Errors
/// A sweep or view with too little data, or views that cannot be aligned.
pub fn calibrate(sweeps: &[Vec<View>]) -> Result<Calibration, CalibrationError> {
    let mut first_number = 1;
    let mut surfaces = Vec::with_capacity(sweeps.len());
    for sweep in sweeps {
        surfaces.push(surfaces_of(sweep, first_number)?);
        first_number += sweep.len();
    }
    let mut found = Isometry3::identity();
    let mut before_m = None;
    let mut equations = Equations::default();
    for (reach_m, steps) in SEARCH {
        for _ in 0..steps {
            equations = Equations::gather(&surfaces, &found, reach_m);
            if equations.pairs() < PAIRS_MIN {
                return Err(CalibrationError::NothingInCommon {
                    count: equations.pairs(),
                    reach_mm: f64::from(1e3 * reach_m),
                });
            }
            before_m.get_or_insert(equations.rms_m());
            let Some(step) = equations.with_prior(&found).step() else {
                break;
            };
            found *= motion(&step);
            if step.norm() < STILL {
                break;
            }
        }
    }
    let agreeing = Equations::gather(&surfaces, &found, SEARCH[0].0).agreeing();
    if agreeing < AGREEING_MIN {
        return Err(CalibrationError::Disagreement {
            share_percent: 100.0 * agreeing,
            needed_percent: 100.0 * AGREEING_MIN,
        });
    }
    let after_m = equations.rms_m();
    let covariance = equations.with_prior(&found).covariance();
    Ok(Calibration {
        believed_from_actual: found,
        covariance,
        open: open_motions(&covariance),
        before_m: before_m.unwrap_or(after_m),
        after_m,
    })
}

/// Convergence: the iteration ends at a step shorter than this (norm of rad and m together).
const STILL: f64 = 1e-6;

fn surfaces_of(sweep: &[View], first_number: usize) -> Result<Vec<Surface>, CalibrationError> {
    if sweep.len() < 2 {
        return Err(CalibrationError::TooFewViews { count: sweep.len() });
    }
    let numbered = (first_number..).zip(sweep);
    numbered
        .map(|(number, view)| {
            Surface::new(view).map_err(|count| CalibrationError::TooFewPoints {
                number,
                count,
                needed: surface::POINTS_MIN,
            })
        })
        .collect()
}

/// Eigenvectors of the covariance, relative to the prior, whose standard deviation is above [`OPEN_ABOVE`].
fn open_motions(covariance: &Matrix6<f64>) -> Vec<Vector6<f64>> {
    let scale = Matrix6::from_diagonal(&prior_sigmas());
    let inverse = Matrix6::from_diagonal(&prior_sigmas().map(f64::recip));
    let eigen = (inverse * covariance * inverse).symmetric_eigen();
    let motions = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    motions
        .map(|(variance, motion)| (variance.max(0.0).sqrt(), motion))
        .filter(|(sigma, _)| *sigma > OPEN_ABOVE)
        .map(|(sigma, motion)| scale * motion * sigma)
        .collect()
}

impl Calibration {
    /// The same calibration expressed in another frame `b` that is fixed to the camera.
    pub fn seen_from(&self, b_from_camera: &Isometry3<f64>) -> Self {
        let turn = *b_from_camera.rotation.to_rotation_matrix().matrix();
        let lever = b_from_camera.translation.vector.cross_matrix() * turn;
        let mut adjoint = Matrix6::zeros();
        adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        adjoint.fixed_view_mut::<3, 3>(3, 0).copy_from(&lever);
        adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        Self {
            believed_from_actual: b_from_camera
                * self.believed_from_actual
                * b_from_camera.inverse(),
            covariance: adjoint * self.covariance * adjoint.transpose(),
            open: self.open.iter().map(|motion| adjoint * motion).collect(),
            ..*self
        }
    }

    /// Standard deviations of the camera's rotation about each of its axes, rad, and of its position along each, m.
    pub fn sigmas(&self) -> (Vector3<f64>, Vector3<f64>) {
        let sigmas = self
            .covariance
            .diagonal()
            .map(|variance| variance.max(0.0).sqrt());
        turn_and_shift(&sigmas)
    }
}

#[cfg(test)]
mod tests;
