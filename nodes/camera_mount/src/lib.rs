//! The pose of the camera on the robot's head, and its calibration.

pub mod calibration;
pub mod file;
mod parameters;
mod steady;

pub use parameters::SweepParameters;
pub use steady::steady_views;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// The mount, with the fields of `config/camera_mount.yaml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraMount {
    /// Frame that carries the camera.
    pub parent_frame: String,
    /// Frame of the camera's body (REP 103: x forward, y left, z up), root of the driver's frames.
    pub child_frame: String,
    /// Position of the camera in the parent frame, metres.
    pub translation_m: [f64; 3],
    /// Roll, pitch and yaw of the camera in the parent frame, radians; positive pitch looks down.
    pub rotation_rpy_rad: [f64; 3],
    /// Parameters of the calibration.
    pub calibration: SweepParameters,
}

impl Default for CameraMount {
    /// On top of Baxter's display, at its own head camera, pitched down like the display.
    fn default() -> Self {
        Self {
            parent_frame: "head".into(),
            child_frame: "camera_link".into(),
            translation_m: [0.12839, 0.0, 0.06368],
            rotation_rpy_rad: [0.0, 0.17977, 0.0],
            calibration: SweepParameters::default(),
        }
    }
}

impl CameraMount {
    /// Checks that the frames are named and the numbers plausible.
    ///
    /// # Errors
    /// A frame without a name, or a place more than 2 m from its parent.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for (name, frame) in [
            ("parent_frame", &self.parent_frame),
            ("child_frame", &self.child_frame),
        ] {
            if frame.is_empty() {
                return Err(ParameterError::new(name, "empty", "the name of a TF frame"));
            }
        }
        let each = |name, values: [f64; 3], limit: f64, unit| {
            values
                .into_iter()
                .try_for_each(|value| in_range(name, value, -limit..=limit, unit))
        };
        each("translation_m", self.translation_m, 2.0, "m")?;
        each(
            "rotation_rpy_rad",
            self.rotation_rpy_rad,
            std::f64::consts::TAU,
            "rad",
        )?;
        self.calibration.validate()
    }

    /// The camera's pose in the parent frame.
    pub fn parent_from_camera(&self) -> Isometry3<f64> {
        let [roll, pitch, yaw] = self.rotation_rpy_rad;
        Isometry3::from_parts(
            Translation3::from(self.translation_m),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }

    /// The same mount with another pose.
    pub fn moved_to(&self, parent_from_camera: &Isometry3<f64>) -> Self {
        let (roll, pitch, yaw) = parent_from_camera.rotation.euler_angles();
        Self {
            translation_m: parent_from_camera.translation.vector.into(),
            rotation_rpy_rad: [roll, pitch, yaw],
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn the_default_looks_forward_and_down() {
        let mount = CameraMount::default();
        assert_eq!(mount.validate(), Ok(()));
        let view = mount.parent_from_camera() * Vector3::x();
        assert!(view.x > 0.98 && view.y.abs() < 1e-12);
        assert!((view.z.asin() + 10.3_f64.to_radians()).abs() < 1e-3);
    }

    #[test]
    fn a_moved_mount_is_where_it_was_moved_to() {
        let place = Isometry3::new(Vector3::new(0.1, -0.02, 0.05), Vector3::new(0.3, 0.2, -0.1));
        let moved = CameraMount::default().moved_to(&place).parent_from_camera();
        assert!((moved.inverse() * place).rotation.angle() < 1e-9);
        assert!((moved.translation.vector - place.translation.vector).norm() < 1e-12);
    }

    #[test]
    fn impossible_mounts_are_named() {
        let fault = |mount: CameraMount| mount.validate().err().map(|error| error.name);
        let far = CameraMount {
            translation_m: [0.0, 3.0, 0.0],
            ..Default::default()
        };
        assert_eq!(fault(far), Some("translation_m"));
        let nan = CameraMount {
            rotation_rpy_rad: [f64::NAN, 0.0, 0.0],
            ..Default::default()
        };
        assert_eq!(fault(nan), Some("rotation_rpy_rad"));
        let nameless = CameraMount {
            child_frame: String::new(),
            ..Default::default()
        };
        assert_eq!(fault(nameless), Some("child_frame"));
    }
}
