//! By how much the stamps of images and joint states disagree, as the views of a turning wrist tell it.
//!
//! Kinematics look the wrist's angle up at the image's stamp s. Where the image was really taken at s + δ of the joints'
//! clock, a wrist that turns at the rate v was v δ farther on by then, and registration has to turn the view by −v δ about the hand's
//! axis. An error of the camera mount asks for no such turn: all views' hands turn about that one axis, and so the share of
//! the mount's error along it cancels. Hence the least squares of φᵢ = −(vᵢ − v₁) δ over the views, with φᵢ the turn of
//! view i about the axis against the first view, whose pose makes the frame: what registration found, and what is left of it
//! ([`AxisTurn`]). Each view counts by how well its surfaces tell.
//!
//! Views of a wrist at rest, or all of one rate, tell nothing: the merged cloud is as good as without the offset then, and only
//! turned as a whole.

use nalgebra::Isometry3;

use crate::axis_turn::AxisTurn;

/// Uncertainty that all turns of a scan have in common, rad: as of joints that are off by up to 0.25 degrees.
const TURN_SIGMA_RAD: f64 = 0.003;
/// Fewer views than this say too little about their own scatter.
const VIEWS_MIN: usize = 4;
/// An estimate less certain than this is none, s.
const SIGMA_MAX_S: f64 = 0.02;

/// How much later images were taken than their stamps say, by the joints' clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeOffset {
    /// s.
    pub offset_s: f64,
    /// Standard deviation, s.
    pub sigma_s: f64,
}

/// The views of one scan so far.
#[derive(Debug, Clone, Default)]
pub struct TimeOffsets {
    /// Rate of the first view, rad/s.
    first_rad_s: Option<f64>,
    others: Vec<Turned>,
}

/// A view after the first.
#[derive(Debug, Clone, Copy)]
struct Turned {
    /// Wrist velocity in this view minus wrist velocity in the first view, rad/s.
    faster_rad_s: f64,
    /// φ, rad.
    turn_rad: f64,
    /// Inverse of its variance, rad⁻².
    information: f64,
}

impl TimeOffsets {
    /// Notes a view: the rate of the wrist at its stamp, hand_from_camera by kinematics and as registered, and the turn that is
    /// left then.
    pub fn note(
        &mut self,
        rate_rad_s: f64,
        kinematic: &Isometry3<f64>,
        registered: &Isometry3<f64>,
        left: AxisTurn,
    ) {
        let Some(first_rad_s) = self.first_rad_s else {
            self.first_rad_s = Some(rate_rad_s);
            return;
        };
        let found = registered.rotation * kinematic.rotation.inverse();
        self.others.push(Turned {
            faster_rad_s: rate_rad_s - first_rad_s,
            turn_rad: found.scaled_axis().z + left.left_rad,
            information: left.information,
        });
    }

    /// What the views tell; `None` where it is too little.
    pub fn estimate(&self) -> Option<TimeOffset> {
        if self.others.len() < VIEWS_MIN {
            return None;
        }
        let sum = |of: &dyn Fn(&Turned) -> f64| self.others.iter().map(of).sum::<f64>();
        let information = sum(&|view| view.information * view.faster_rad_s.powi(2));
        let pull = sum(&|view| view.information * view.faster_rad_s * view.turn_rad);
        let offset_s = -pull / information;
        let residual_sq = |view: &Turned| {
            let residual_rad = view.turn_rad + view.faster_rad_s * offset_s;
            view.information * residual_rad * residual_rad
        };
        // Residuals that are larger than they should be tell of what the views' own uncertainties leave out.
        let scatter = (sum(&residual_sq) / (self.others.len() - 1) as f64).max(1.0);
        let shared_sq = TURN_SIGMA_RAD.powi(2) * sum(&|view| view.information) / information;
        let sigma_s = (scatter / information + shared_sq).sqrt();
        (sigma_s <= SIGMA_MAX_S).then_some(TimeOffset { offset_s, sigma_s })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    const CAMERA: Vector3<f64> = Vector3::new(0.4, 0.1, 0.2);

    /// hand_from_camera with the wrist at an angle.
    fn hand_from_camera(wrist_rad: f64) -> Isometry3<f64> {
        let looks = UnitQuaternion::from_euler_angles(0.3, -1.2, 0.4);
        Isometry3::rotation(Vector3::z() * -wrist_rad) * Translation3::from(CAMERA) * looks
    }

    /// A sweep whose views are registered without error, with the mount off by `mount`.
    fn swept(rates_rad_s: &[f64], offset_s: f64, mount: &Isometry3<f64>) -> TimeOffsets {
        let mut offsets = TimeOffsets::default();
        let actual = |index: usize, rate_rad_s: f64| {
            hand_from_camera(0.1 * index as f64 + rate_rad_s * offset_s)
        };
        let believed = |index: usize| hand_from_camera(0.1 * index as f64) * mount;
        let registered_from_hand = believed(0) * actual(0, rates_rad_s[0]).inverse();
        for (index, rate_rad_s) in rates_rad_s.iter().enumerate() {
            let registered = registered_from_hand * actual(index, *rate_rad_s);
            let left = AxisTurn {
                left_rad: 0.0,
                information: 1e4,
            };
            offsets.note(*rate_rad_s, &believed(index), &registered, left);
        }
        offsets
    }

    const SWEEP: [f64; 8] = [0.0, 0.9, 1.15, 1.15, 1.15, 1.15, 1.15, 0.4];

    #[test]
    fn a_sweep_from_rest_tells_the_offset_whatever_the_mount() {
        let mount = Isometry3::new(
            Vector3::new(0.006, -0.004, 0.007),
            Vector3::new(0.02, -0.015, 0.02),
        );
        for offset_s in [-0.02, 0.0, 0.013] {
            for mount in [Isometry3::identity(), mount] {
                let found = swept(&SWEEP, offset_s, &mount).estimate().unwrap();
                // The mount's error is no small angle to the last digit.
                assert!((found.offset_s - offset_s).abs() < 1e-3, "{found:?}");
                assert!(found.sigma_s < 1.5e-2, "{found:?}");
            }
        }
    }

    #[test]
    fn a_steady_rate_tells_nothing() {
        let mount = Isometry3::identity();
        assert_eq!(swept(&[1.15; 8], 0.02, &mount).estimate(), None);
        assert_eq!(swept(&[0.0; 8], 0.02, &mount).estimate(), None);
        assert_eq!(swept(&[0.0, 1.15, 1.15], 0.02, &mount).estimate(), None);
        let is_nowhere = swept(&[0.0, f64::NAN, 1.0, 1.0, 1.0], 0.02, &mount);
        assert_eq!(is_nowhere.estimate(), None);
    }
}
