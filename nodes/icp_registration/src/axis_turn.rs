//! By how much a registered view would still have to be turned about the hand's axis to lie on the first view.
//!
//! Registration leaves a turn alone that the surfaces hardly tell, and lays each view onto all before it, which share the turn
//! that a clock skew gives to views of a moving wrist. Against the first view alone, dents and fingers tell that turn.
//!
//! The normals' noise would make the least-squares estimate too small (errors in variables), here by far: on the side of a can
//! hardly any point moves along its normal when the can turns. The view's own normals serve as instrumental variables (Reiersøl
//! 1941): their noise is independent of that of the first view's.

use cloud::normals;
use hand_eye::{PATCHES_PER_VIEW, SHIFT_SIGMA_M, TURN_SIGMA_RAD};
use nalgebra::{Matrix6, Point3, Vector3, Vector6};

use crate::error::RegistrationError;
use crate::matching::Matcher;
use crate::model::{Model, PATCH_VOXELS, Searchable};
use crate::mount::SURFACE_SIGMA_M;
use crate::observability::Twists;
use crate::parameters::Parameters;

/// The turn that is left.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AxisTurn {
    /// rad, about z of the hand's frame.
    pub left_rad: f64,
    /// Inverse of its variance, rad⁻²; 0 where the surfaces do not tell.
    pub information: f64,
}

/// Points farther than this from the first view's surface lie on something else, m: four times a D435i's noise at half a metre.
const GAP_MAX_M: f32 = 0.004;
/// Cosine of the largest angle between the normals of a pair.
const ALIKE: f32 = 0.9;
/// A turn that is known less well than this is not known at all, rad⁻²: a standard deviation of 0.2 rad.
const INFORMATION_MIN: f64 = 25.0;
/// Index of the turn about z among the six motions.
const TURN_Z: usize = 2;

/// The surface that turns are measured against.
#[derive(Debug, Clone)]
pub(crate) struct FirstView {
    surface: Searchable,
    /// Of its points; `None` where it is not flat.
    normals: Vec<Option<Vector3<f32>>>,
}

impl FirstView {
    /// Of a model that has one view. `None` for an empty one.
    pub(crate) fn of(model: &Model) -> Result<Option<Self>, RegistrationError> {
        let Some(surface) = model.searchable() else {
            return Ok(None);
        };
        let normals = model.normals().map_err(RegistrationError::TooLarge)?;
        Ok(Some(Self {
            surface: surface.clone(),
            normals: normals.to_vec(),
        }))
    }

    /// The turn of a view whose points lie where registration put them.
    pub(crate) fn turn_of(
        &self,
        view: &[Point3<f32>],
        parameters: &Parameters,
    ) -> Result<AxisTurn, RegistrationError> {
        let own = normals::of_patches(view, PATCH_VOXELS * self.surface.voxel_m);
        let own = own.map_err(RegistrationError::TooLarge)?;
        let turn = self.estimate(view, &own, parameters);
        Ok(turn.unwrap_or_default())
    }

    /// Solves (Σ zᵢjᵢᵀ) ξ = Σ zᵢrᵢ for the motion ξ, with rᵢ the distance of a point from the first view's surface, jᵢ how
    /// far ξ moves it along that surface's normal, and zᵢ the same along its own view's.
    fn estimate(
        &self,
        view: &[Point3<f32>],
        own: &[Option<Vector3<f32>>],
        parameters: &Parameters,
    ) -> Option<AxisTurn> {
        let twists = Twists::around(view)?;
        let reach_m = parameters.max_correspondence_m as f32;
        let mut matcher = Matcher::new(&self.surface, reach_m, view.len());
        let (mut sum, mut pull, mut used) = (Matrix6::zeros(), Vector6::zeros(), 0);
        for (number, (point, own)) in view.iter().zip(own).enumerate() {
            let (Some(own), Some(found)) = (own, matcher.nearest(number, point)) else {
                continue;
            };
            let Some(normal) = self.normals[found.index] else {
                continue;
            };
            let alike = own.dot(&normal);
            let gap_m = (self.surface.points[found.index] - point).dot(&normal);
            let aside_sq = found.distance_sq - gap_m * gap_m;
            let is_pair = alike.abs() > ALIKE && gap_m.abs() < GAP_MAX_M;
            if !is_pair || aside_sq > parameters.aside_max_sq() {
                continue;
            }
            let instrument = twists.effect(point, &(own * alike.signum()));
            sum += instrument * twists.effect(point, &normal).transpose();
            pull += instrument * f64::from(gap_m);
            used += 1;
        }
        let per_pair = PATCHES_PER_VIEW / (SURFACE_SIGMA_M.powi(2) * f64::from(used.max(1)));
        let radius_m = twists.radius_m();
        let covariance = (sum * per_pair + prior_of_the_others(radius_m)).try_inverse()?;
        let turn = AxisTurn {
            left_rad: (covariance * pull * per_pair)[TURN_Z] / radius_m,
            information: radius_m.powi(2) / covariance[(TURN_Z, TURN_Z)],
        };
        (turn.left_rad.is_finite() && turn.information >= INFORMATION_MIN).then_some(turn)
    }
}

/// Information that the other five motions are small, as a mount's error leaves them.
fn prior_of_the_others(radius_m: f64) -> Matrix6<f64> {
    let (turn, shift) = ((TURN_SIGMA_RAD * radius_m).powi(-2), SHIFT_SIGMA_M.powi(-2));
    Matrix6::from_diagonal(&Vector6::new(turn, turn, 0.0, shift, shift, shift))
}
