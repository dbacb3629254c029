//! One view of a simulated scan.

use nalgebra::{Isometry3, Point3};

/// What the camera sees of a scan at one wrist angle.
#[derive(Debug, Clone)]
pub struct View {
    /// Points in m in the camera's optical frame: gripper and object.
    pub points: Vec<Point3<f32>>,
    /// The pose that kinematics would report, wrong by the camera mount's error.
    pub believed_hand_from_camera: Isometry3<f64>,
}
