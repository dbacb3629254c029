//! Where the simulated camera really sits on the robot's head. What the robot believes of it, TF says.

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// The place of the camera's body (REP 103: x forward, y left, z up).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mount {
    /// Frame that carries the camera.
    pub parent_frame: String,
    /// Position in the parent frame, m.
    pub translation_m: [f64; 3],
    /// Roll, pitch and yaw in the parent frame, rad; positive pitch looks down.
    pub rotation_rpy_rad: [f64; 3],
}

impl Default for Mount {
    /// On Baxter's display, where the robot believes it to be unless told otherwise.
    fn default() -> Self {
        Self {
            parent_frame: "head".into(),
            translation_m: [0.12839, 0.0, 0.06368],
            rotation_rpy_rad: [0.0, 0.17977, 0.0],
        }
    }
}

impl Mount {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        if self.parent_frame.is_empty() {
            let name = "mount/parent_frame";
            return Err(ParameterError::new(name, "empty", "the name of a TF frame"));
        }
        for value in self.translation_m {
            in_range("mount/translation_m", value, -2.0..=2.0, "m")?;
        }
        for value in self.rotation_rpy_rad {
            in_range("mount/rotation_rpy_rad", value, -6.3..=6.3, "rad")?;
        }
        Ok(())
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
