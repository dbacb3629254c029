//! What the views of a scan say about the camera mount.
//!
//! Where kinematics put the camera is wrong by one and the same motion X in all views, as long as it stays on the head.
//! With A the camera's motion since the first view by kinematics, and B that by registration, A X = X B: the equation of
//! hand-eye calibration (Shiu & Ahmad 1989). The next view then starts where X puts it, not where kinematics do: an error
//! of the mount that turns with the wrist would otherwise grow from view to view until it is out of bounds.

use nalgebra::{Isometry3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

use crate::observability::Certainty;

/// How far the mount is off as a rule.
const TURN_SIGMA_RAD: f64 = 0.026;
const SHIFT_SIGMA_M: f64 = 0.008;
/// How far a view's surface is off its place once it is registered, along its normal.
const SURFACE_SIGMA_M: f64 = 0.001;
/// A camera's errors are alike over a patch of its image: so many patches speak for themselves.
const PATCHES: f64 = 30.0;

/// What was learned from the views so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct MountError {
    /// hand_from_camera of the first view.
    first: Option<Isometry3<f64>>,
    seen: Vec<Seen>,
    /// X: camera as kinematics have it, from camera as it is.
    believed_from_actual: Isometry3<f64>,
}

/// One view after the first.
#[derive(Debug, Clone)]
struct Seen {
    /// A: first camera from camera, by kinematics.
    by_kinematics: Isometry3<f64>,
    /// hand_from_camera by registration.
    registered: Isometry3<f64>,
    /// How exactly.
    certainty: Certainty,
}

impl MountError {
    /// Where a view starts: its hand_from_camera as kinematics have it, corrected by what is known of the mount. The
    /// correction is against the first view, which keeps its place.
    pub(crate) fn start(&self, hand_from_camera: &Isometry3<f64>) -> Isometry3<f64> {
        match &self.first {
            None => *hand_from_camera,
            Some(first) => first * self.expected(&(first.inverse() * hand_from_camera)),
        }
    }

    /// Notes the first view's hand_from_camera by kinematics.
    pub(crate) fn begin(&mut self, hand_from_camera: &Isometry3<f64>) {
        self.first = Some(*hand_from_camera);
    }

    /// Notes another view's hand_from_camera: by kinematics, and by registration.
    pub(crate) fn learn(
        &mut self,
        hand_from_camera: &Isometry3<f64>,
        registered: &Isometry3<f64>,
        certainty: Certainty,
    ) {
        if let Some(first) = self.first {
            self.seen.push(Seen {
                by_kinematics: first.inverse() * hand_from_camera,
                registered: *registered,
                certainty,
            });
            self.solve(&first);
        }
    }

    /// B = X⁻¹ A X.
    fn expected(&self, by_kinematics: &Isometry3<f64>) -> Isometry3<f64> {
        self.believed_from_actual.inverse() * by_kinematics * self.believed_from_actual
    }

    /// The most probable X, by Gauss-Newton steps from the last one.
    fn solve(&mut self, first: &Isometry3<f64>) {
        const STEPS: usize = 4;
        const SLOPE_STEP: f64 = 1e-6;
        const WEIGHT: f64 = PATCHES / (SURFACE_SIGMA_M * SURFACE_SIGMA_M);
        for _ in 0..STEPS {
            let (mut information, mut pull) = self.prior();
            for seen in &self.seen {
                let off = |moved: Vector6<f64>| self.off(first, seen, &moved);
                let here = off(Vector6::zeros());
                let mut slopes = Matrix6::zeros();
                for (column, mut slope) in slopes.column_iter_mut().enumerate() {
                    slope.copy_from(&((off(Vector6::ith(column, SLOPE_STEP)) - here) / SLOPE_STEP));
                }
                let weighted = slopes.transpose() * seen.certainty.information * WEIGHT;
                information += weighted * slopes;
                pull -= weighted * here;
            }
            if let Some(cholesky) = information.cholesky() {
                self.believed_from_actual *= motion(&cholesky.solve(&pull));
            }
        }
    }

    fn prior(&self) -> (Matrix6<f64>, Vector6<f64>) {
        let weight = |sigma: f64| 1.0 / (sigma * sigma);
        let (turn, shift) = (weight(TURN_SIGMA_RAD), weight(SHIFT_SIGMA_M));
        let weights = Vector6::new(turn, turn, turn, shift, shift, shift);
        let turned = self.believed_from_actual.rotation.scaled_axis();
        let shifted = self.believed_from_actual.translation.vector;
        let amounts = Vector6::from_iterator(turned.iter().chain(shifted.iter()).copied());
        let information = Matrix6::from_diagonal(&weights);
        (information, -(information * amounts))
    }

    /// How far a view is from where X, moved a little, puts it, m: in the six motions that its certainty speaks of.
    fn off(&self, first: &Isometry3<f64>, seen: &Seen, moved: &Vector6<f64>) -> Vector6<f64> {
        let mount = self.believed_from_actual * motion(moved);
        let expected = first * mount.inverse() * seen.by_kinematics * mount;
        seen.certainty
            .twists
            .amounts(&(expected * seen.registered.inverse()))
    }
}

/// Turn (rad) and shift (m) as a motion.
fn motion(amounts: &Vector6<f64>) -> Isometry3<f64> {
    let turn: Vector3<f64> = amounts.fixed_rows::<3>(0).into();
    let shift: Vector3<f64> = amounts.fixed_rows::<3>(3).into();
    Isometry3::from_parts(
        Translation3::from(shift),
        UnitQuaternion::from_scaled_axis(turn),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Point3;

    use super::*;
    use crate::observability::Twists;
    use crate::tests::scene::hand_from_camera;

    const MIDDLE: Point3<f64> = Point3::new(0.0, 0.0, 0.1877);

    /// All motions of a hand-sized object known alike.
    fn certainty() -> Certainty {
        let corners = [-0.04, 0.04].map(|x| (MIDDLE + Vector3::new(x, x, x)).cast());
        Certainty {
            twists: Twists::around(&corners).unwrap(),
            information: Matrix6::identity() / 3.0,
        }
    }

    #[test]
    fn the_next_view_starts_where_the_mounts_error_puts_it() {
        let error = Isometry3::new(
            Vector3::new(0.006, -0.005, 0.004),
            Vector3::new(0.02, -0.015, 0.02),
        );
        // The first view keeps its place, so that all is seen through its error.
        let registered = |wrist_rad: f64| {
            hand_from_camera(0.0)
                * error.inverse()
                * hand_from_camera(0.0).inverse()
                * hand_from_camera(wrist_rad)
                * error
        };
        let off_m = |mount: &MountError, wrist_rad: f64| {
            let place = registered(wrist_rad).inverse() * MIDDLE;
            (mount.start(&hand_from_camera(wrist_rad)) * place - MIDDLE).norm()
        };
        let mut mount = MountError::default();
        mount.begin(&hand_from_camera(0.0));
        let before_m = off_m(&mount, 1.2);
        mount.learn(&hand_from_camera(0.6), &registered(0.6), certainty());
        let after_m = off_m(&mount, 1.2);
        println!(
            "off by {:.2} mm, {:.2} mm without",
            1e3 * after_m,
            1e3 * before_m
        );
        assert!(before_m > 0.008 && after_m < 0.15 * before_m);
    }

    #[test]
    fn what_is_not_determined_says_nothing() {
        let mut mount = MountError::default();
        mount.begin(&hand_from_camera(0.0));
        let none = Certainty {
            information: Matrix6::zeros(),
            ..certainty()
        };
        let elsewhere = Isometry3::translation(0.01, 0.0, 0.0) * hand_from_camera(0.6);
        mount.learn(&hand_from_camera(0.6), &elsewhere, none);
        let pose = hand_from_camera(1.2);
        assert!(
            (mount.start(&pose).inverse() * pose)
                .translation
                .vector
                .norm()
                < 1e-9
        );
    }
}
