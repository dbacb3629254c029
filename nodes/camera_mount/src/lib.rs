//! Where the camera sits on the robot's head.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The mount, as `config/camera_mount.yaml` holds it.
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
}

impl Default for CameraMount {
    /// On Baxter's display, where its own head camera looks from, pitched down as the display is.
    fn default() -> Self {
        Self {
            parent_frame: "head".into(),
            child_frame: "camera_link".into(),
            translation_m: [0.12839, 0.0, 0.06368],
            rotation_rpy_rad: [0.0, 0.17977, 0.0],
        }
    }
}

/// A mount that cannot be.
#[derive(Debug, Error, PartialEq)]
pub enum MountError {
    /// A frame has no name.
    #[error("{0} is empty; name a TF frame")]
    NoFrame(&'static str),
    /// A number is not finite or no metre long.
    #[error("{name} is {value:?}; {allowed}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: [f64; 3],
        /// What it may be.
        allowed: &'static str,
    },
}

impl CameraMount {
    /// Checks that the frames are named and the numbers plausible.
    pub fn validate(&self) -> Result<(), MountError> {
        if self.parent_frame.is_empty() {
            return Err(MountError::NoFrame("parent_frame"));
        }
        if self.child_frame.is_empty() {
            return Err(MountError::NoFrame("child_frame"));
        }
        within(
            "translation_m",
            self.translation_m,
            2.0,
            "each must lie within ±2 m",
        )?;
        within(
            "rotation_rpy_rad",
            self.rotation_rpy_rad,
            6.2832,
            "each must lie within ±2π rad",
        )
    }

    /// parent_from_camera.
    pub fn parent_from_camera(&self) -> Isometry3<f64> {
        let [roll, pitch, yaw] = self.rotation_rpy_rad;
        Isometry3::from_parts(
            Translation3::from(self.translation_m),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }
}

fn within(
    name: &'static str,
    value: [f64; 3],
    limit: f64,
    allowed: &'static str,
) -> Result<(), MountError> {
    // Written so that what is not a number fails too.
    if value.iter().all(|v| v.abs() <= limit) {
        Ok(())
    } else {
        Err(MountError::OutOfRange {
            name,
            value,
            allowed,
        })
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
    fn impossible_mounts_are_named() {
        let far = CameraMount {
            translation_m: [0.0, 3.0, 0.0],
            ..Default::default()
        };
        assert!(matches!(
            far.validate(),
            Err(MountError::OutOfRange {
                name: "translation_m",
                ..
            })
        ));
        let nan = CameraMount {
            rotation_rpy_rad: [f64::NAN, 0.0, 0.0],
            ..Default::default()
        };
        assert!(nan.validate().is_err());
        let nameless = CameraMount {
            child_frame: String::new(),
            ..Default::default()
        };
        assert_eq!(nameless.validate(), Err(MountError::NoFrame("child_frame")));
    }
}
