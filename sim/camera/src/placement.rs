//! Where the parts of a scene are, seen from the camera.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Poses of a scene's parts in the camera's optical frame (x right, y down, z forward).
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Pose of the hand, with gripper, wrist and object.
    pub camera_from_hand: Isometry3<f64>,
    /// Pose of each of [`crate::Scene::links`], in their order; a link without a pose is not drawn.
    pub camera_from_links: Vec<Option<Isometry3<f64>>>,
    /// Pose of the robot's base, in which the wall stands; without it there is no wall.
    pub camera_from_base: Option<Isometry3<f64>>,
}

impl Placement {
    /// From poses in the robot's base. The arm's links below the wrist are left out.
    pub fn in_base(base_from_camera: &Isometry3<f64>, base_from_hand: &Isometry3<f64>) -> Self {
        let camera_from_base = base_from_camera.inverse();
        Self {
            camera_from_hand: camera_from_base * base_from_hand,
            camera_from_links: Vec::new(),
            camera_from_base: Some(camera_from_base),
        }
    }

    /// Pose of the camera in the hand's frame.
    pub fn hand_from_camera(&self) -> Isometry3<f64> {
        self.camera_from_hand.inverse()
    }
}

/// The camera's optical frame in Baxter's base: on the head at pan 0, pitched 10.3 degrees down.
pub fn scan_base_from_camera() -> Isometry3<f64> {
    const PITCH_RAD: f64 = 10.3 * PI / 180.0;
    let base_from_head = Translation3::new(0.06, 0.0, 0.686);
    let head_from_body = Translation3::new(0.12839, 0.0, 0.06368)
        * UnitQuaternion::from_euler_angles(0.0, PITCH_RAD, 0.0);
    let body_from_optical = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    base_from_head * head_from_body * body_from_optical
}

/// The hand in Baxter's base in the scan pose at pan 0: pointing up, 0.40 m in front of the camera, with joint W2 at
/// `wrist_rad`.
pub fn scan_base_from_hand(wrist_rad: f64) -> Isometry3<f64> {
    /// Direction of the hand's x axis in that pose where W2 is 0. A finger is then nearly between camera and object.
    const YAW_RAD: f64 = 1.8914;
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, YAW_RAD + wrist_rad);
    Translation3::new(0.584, 0.0, 0.461) * turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{D435I, project};
    use nalgebra::Point3;

    #[test]
    fn in_the_scan_pose_the_object_is_upright_in_the_middle_of_the_image() {
        for wrist_rad in [-0.6, 0.0, 0.6] {
            let placement =
                Placement::in_base(&scan_base_from_camera(), &scan_base_from_hand(wrist_rad));
            let low = placement.camera_from_hand * Point3::new(0.0, 0.0, 0.1277);
            let high = placement.camera_from_hand * Point3::new(0.0, 0.0, 0.2477);
            assert!((0.35..0.46).contains(&low.z) && (0.35..0.46).contains(&high.z));
            let [low, high] = [low, high].map(|point| project(&D435I, &point));
            assert!((low[0] - 424.158).abs() < 1e-6 && (high[0] - 424.158).abs() < 1e-6);
            assert!(
                high[1] > 100.0 && high[1] < low[1] && low[1] < 400.0,
                "{low:?} {high:?}"
            );
        }
    }
}
