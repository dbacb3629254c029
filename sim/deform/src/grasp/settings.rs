//! Settings of the gripper and of the region in which it may grasp.

use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};

use super::GraspError;

/// Settings of [`super::Grasps`].
///
/// The gripper is Baxter's electric one. With its wide fingers in the first slot its pads open to 114 mm (its URDF:
/// closed 72.6 mm, two strokes of 20.8 mm), which takes all eight objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraspSettings {
    /// Share of the length, about its middle, within which fingers may press.
    pub graspable_ratio: f64,
    /// Share of the graspable vertices that are handles by default.
    pub sampling_ratio: f64,
    /// Thickness of the slice in which the opposite handle is looked for.
    pub slice_m: f64,
    /// Distance between the open gripper's pads.
    pub opening_max_m: f64,
    /// Diameter of the part of a finger pad that touches.
    pub finger_width_m: f64,
    /// Thickest wall that gives way as one: what lies so little behind the pad moves with it.
    pub wall_max_m: f64,
    /// Direction of the long side; found where it is not given.
    pub long_axis: Option<Unit<Vector3<f64>>>,
}

impl Default for GraspSettings {
    fn default() -> Self {
        Self {
            graspable_ratio: 0.9,
            sampling_ratio: 0.035,
            slice_m: 0.001,
            opening_max_m: 0.114,
            finger_width_m: 0.012,
            wall_max_m: 0.003,
            long_axis: None,
        }
    }
}

impl GraspSettings {
    /// Checks that every setting is in its range.
    ///
    /// # Errors
    /// [`GraspError::Setting`] names the first value out of range.
    pub fn validate(&self) -> Result<(), GraspError> {
        let in_range = |name, value: f64, min: f64, max: f64| {
            if value > min && value <= max {
                return Ok(());
            }
            Err(GraspError::Setting {
                name,
                value,
                min,
                max,
            })
        };
        // At 1 no vertex would be held, and the object would move away from the fingers as a whole.
        in_range("graspable_ratio", self.graspable_ratio, 0.0, 0.999)?;
        in_range("sampling_ratio", self.sampling_ratio, 0.0, 1.0)?;
        in_range("slice_m", self.slice_m, 0.0, 1.0)?;
        in_range("opening_max_m", self.opening_max_m, 0.0, 10.0)?;
        in_range("finger_width_m", self.finger_width_m, 0.0, 1.0)?;
        in_range("wall_max_m", self.wall_max_m, 0.0, 0.1)?;
        let length = self.long_axis.map_or(1.0, |axis| axis.norm());
        in_range("length of long_axis", length, 1e-9, 1e9)
    }
}
