//! Gauss-Newton steps for the mount's error X.

use nalgebra::{Isometry3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

use crate::{SHIFT_SIGMA_M, TURN_SIGMA_RAD};

/// Normal equations of one Gauss-Newton step. Their solution is the small motion of the camera, in its own frame, that makes
/// X most probable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equations {
    information: Matrix6<f64>,
    pull: Vector6<f64>,
}

impl Equations {
    /// The prior: normal distributions around 0 with standard deviation [`TURN_SIGMA_RAD`] for each rotation and
    /// [`SHIFT_SIGMA_M`] for each translation.
    pub fn prior(believed_from_actual: &Isometry3<f64>) -> Self {
        let information = prior_sigmas().map(|sigma| sigma.powi(-2));
        Self {
            information: Matrix6::from_diagonal(&information),
            pull: -information.component_mul(&amounts(believed_from_actual)),
        }
    }

    /// Adds a measurement: its information matrix (inverse covariance of the six coordinates), and the information matrix
    /// times the step that this measurement alone would give.
    pub fn add(&mut self, information: &Matrix6<f64>, pull: &Vector6<f64>) {
        self.information += information;
        self.pull += pull;
    }

    /// Solves for the step: rotation vector (rad) and translation (m), to be applied on the right of X. `None` if a number
    /// is not finite.
    pub fn step(&self) -> Option<Vector6<f64>> {
        let cholesky = self.information.cholesky()?;
        Some(cholesky.solve(&self.pull)).filter(|step| step.iter().all(|number| number.is_finite()))
    }

    /// Covariance of X, in rad and m; that of the prior if the equations cannot be solved.
    pub fn covariance(&self) -> Matrix6<f64> {
        let prior = || Matrix6::from_diagonal(&prior_sigmas().map(|sigma| sigma * sigma));
        let cholesky = self.information.cholesky();
        cholesky.map_or_else(prior, |cholesky| cholesky.inverse())
    }
}

/// Standard deviations of the prior: three rotations (rad), three translations (m).
pub fn prior_sigmas() -> Vector6<f64> {
    let (turn, shift) = (TURN_SIGMA_RAD, SHIFT_SIGMA_M);
    Vector6::new(turn, turn, turn, shift, shift, shift)
}

/// A rigid motion from its six coordinates: rotation vector (rad), then translation (m).
pub fn motion(amounts: &Vector6<f64>) -> Isometry3<f64> {
    let (turn, shift) = turn_and_shift(amounts);
    let rotation = UnitQuaternion::from_scaled_axis(turn);
    Isometry3::from_parts(Translation3::from(shift), rotation)
}

/// The six coordinates of a rigid motion; the inverse of [`motion`].
pub fn amounts(motion: &Isometry3<f64>) -> Vector6<f64> {
    let (turn, shift) = (motion.rotation.scaled_axis(), motion.translation.vector);
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}

/// Splits six coordinates into rotation vector (rad) and translation (m).
pub fn turn_and_shift(amounts: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let half = |start| amounts.fixed_rows::<3>(start).into();
    (half(0), half(3))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn without_views_the_mount_is_where_it_was_measured() {
        let off = motion(&Vector6::new(0.02, 0.0, -0.01, 0.003, 0.0, 0.01));
        let step = Equations::prior(&off).step().unwrap();
        assert!((step + amounts(&off)).norm() < 1e-12);
    }

    #[test]
    fn a_sharp_measurement_outweighs_the_prior_where_it_speaks() {
        let mut equations = Equations::prior(&Isometry3::identity());
        let information = Vector6::new(1e8, 0.0, 0.0, 0.0, 0.0, 0.0);
        let wanted = Vector6::new(0.03, 0.5, 0.0, 0.0, 0.0, 0.0);
        let pull = information.component_mul(&wanted);
        equations.add(&Matrix6::from_diagonal(&information), &pull);
        let step = equations.step().unwrap();
        assert!((step[0] - 0.03).abs() < 1e-5 && step[1].abs() < 1e-12);
        let sigmas = equations.covariance().diagonal().map(f64::sqrt);
        assert!(sigmas[0] < 2e-4 && (sigmas[1] - TURN_SIGMA_RAD).abs() < 1e-9);
    }

    #[test]
    fn what_is_not_finite_is_no_step() {
        let mut equations = Equations::prior(&Isometry3::identity());
        equations.add(&Matrix6::zeros(), &Vector6::repeat(f64::NAN));
        assert_eq!(equations.step(), None);
    }

    #[test]
    fn amounts_and_motion_undo_each_other() {
        let wanted = Vector6::new(0.2, -0.1, 0.4, 0.01, 0.02, -0.03);
        assert!((amounts(&motion(&wanted)) - wanted).norm() < 1e-12);
    }
}
