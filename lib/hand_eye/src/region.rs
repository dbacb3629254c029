//! Which part of space turns with the hand.

use nalgebra::Point3;

/// The upright cylinder about the hand's z axis in which everything turns with the wrist: gripper and object.
///
/// In the hand's frame (+z out along the gripper), m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandRegion {
    /// Height of the cylinder's lower end; it has no upper one.
    pub above_m: f64,
    /// Radius of the cylinder.
    pub radius_m: f64,
}

impl Default for HandRegion {
    /// Baxter's wrist turns everything from 116 mm below the hand's frame upwards (URDF: left_w2 to left_hand); the forearm
    /// below stands still. Starting 20 mm above the frame keeps the forearm out even if the mount is off by several cm. The
    /// widest object reaches 44 mm from the axis and open fingers 65 mm; beyond 120 mm is the arm or a bystander.
    fn default() -> Self {
        Self {
            above_m: 0.02,
            radius_m: 0.12,
        }
    }
}

impl HandRegion {
    /// Whether a point of the hand's frame (m) turns with the hand.
    pub fn holds(&self, point: &Point3<f32>) -> bool {
        let radius_m = self.radius_m as f32;
        point.z > self.above_m as f32 && point.xy().coords.norm_squared() < radius_m * radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_forearm_and_the_other_arm_do_not_turn_with_the_hand() {
        let region = HandRegion::default();
        let holds = |x, y, z| region.holds(&Point3::new(x, y, z));
        assert!(holds(0.04, -0.04, 0.25) && holds(0.0, 0.06, 0.05));
        assert!(!holds(0.0, 0.0, -0.05) && !holds(0.1, 0.1, 0.2));
    }
}
