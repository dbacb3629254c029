//! What the views of a scan say about the camera mount.
//!
//! Where kinematics put the camera is wrong by one and the same motion X in all views, as long as it stays on the head.
//! With A the camera's motion since the first view by kinematics, and B that by registration, A X = X B: the equation of
//! hand-eye calibration (Shiu & Ahmad 1989). The next view then starts where X puts it, not where kinematics do: an error
//! of the mount that turns with the wrist would otherwise grow from view to view until it is out of bounds.

use hand_eye::{Equations, PATCHES_PER_VIEW, motion};
use nalgebra::{Isometry3, Matrix6, Point3, Vector3, Vector6};

use crate::observability::Certainty;

/// How far a view's surface is off its place once it is registered, along its normal, m.
pub(crate) const SURFACE_SIGMA_M: f64 = 0.001;

/// What was learned from the views so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct MountError {
    /// hand_from_camera of the first view.
    first: Option<Isometry3<f64>>,
    seen: Vec<Seen>,
    /// X: camera as kinematics have it, from camera as it is.
    believed_from_actual: Isometry3<f64>,
}

/// About where the middle of an object is in the hand's frame.
const OBJECT_MIDDLE: Point3<f64> = Point3::new(0.0, 0.0, 0.19);

/// How far the hand's axis is from where kinematics and the mount put it: all that turns of the wrist tell of the mount
/// that matters to the crop. How far the hand is off along its axis, they do not tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Displacement {
    /// Across the axis, at the height of the object, m.
    pub sideways_m: f64,
    /// Angle between the axes, rad.
    pub tilt_rad: f64,
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

    /// How far the hand is from where kinematics put it; `None` before a second view told.
    pub(crate) fn displacement(&self) -> Option<Displacement> {
        let first = self.first.filter(|_| !self.seen.is_empty())?;
        let actual_from_believed = first * self.believed_from_actual * first.inverse();
        let moved = actual_from_believed * OBJECT_MIDDLE - OBJECT_MIDDLE;
        let axis = actual_from_believed * Vector3::z();
        Some(Displacement {
            sideways_m: moved.xy().norm(),
            tilt_rad: axis.angle(&Vector3::z()),
        })
    }

    /// B = X⁻¹ A X.
    fn expected(&self, by_kinematics: &Isometry3<f64>) -> Isometry3<f64> {
        self.believed_from_actual.inverse() * by_kinematics * self.believed_from_actual
    }

    /// The most probable X, by Gauss-Newton steps from the last one.
    fn solve(&mut self, first: &Isometry3<f64>) {
        const STEPS: usize = 4;
        const SLOPE_STEP: f64 = 1e-6;
        const WEIGHT: f64 = PATCHES_PER_VIEW / (SURFACE_SIGMA_M * SURFACE_SIGMA_M);
        for _ in 0..STEPS {
            let mut equations = Equations::prior(&self.believed_from_actual);
            for seen in &self.seen {
                let off = |moved: Vector6<f64>| self.off(first, seen, &moved);
                let here = off(Vector6::zeros());
                let mut slopes = Matrix6::zeros();
                for (column, mut slope) in slopes.column_iter_mut().enumerate() {
                    slope.copy_from(&((off(Vector6::ith(column, SLOPE_STEP)) - here) / SLOPE_STEP));
                }
                let weighted = slopes.transpose() * seen.certainty.information * WEIGHT;
                equations.add(&(weighted * slopes), &(-weighted * here));
            }
            if let Some(step) = equations.step() {
                self.believed_from_actual *= motion(&step);
            }
        }
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

#[cfg(test)]
mod tests;
