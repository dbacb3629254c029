//! The world in front of the camera.

use nalgebra::Translation3;

use crate::gripper;
use sim_objects::Mesh;

/// Height in the hand's frame at which an object's bottom is: fingertips less 30 mm of grasp depth.
pub const OBJECT_BOTTOM_Z_M: f32 = gripper::TIP_Z_M - gripper::GRASP_DEPTH_M;

/// A part of the arm that moves on its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// TF frame that it moves with.
    pub frame: String,
    /// Its shape in that frame.
    pub mesh: Mesh,
}

/// Object, gripper, arm and wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Everything that moves with the hand, in its frame: gripper, wrist and object.
    pub hand: Mesh,
    /// Forearm of the left arm.
    pub links: Vec<Link>,
    /// Where the wall stands, in Baxter's base; `None` for open space.
    pub wall_x_m: Option<f64>,
}

impl Scene {
    /// The gripper closed on an upright object, given in its own frame (bottom centre, +z up).
    ///
    /// The object's axis is the hand's; the fingers close along y until they touch it.
    pub fn holding(object: &Mesh) -> Self {
        let opening = gripper::opening_for(object);
        let mut scene = Self::with_gripper(&opening);
        let hand_from_object = Translation3::new(0.0, 0.0, OBJECT_BOTTOM_Z_M).into();
        scene.hand.append(&object.transformed(&hand_from_object));
        scene
    }

    /// The gripper open and empty.
    pub fn empty_handed() -> Self {
        Self::with_gripper(&gripper::Opening::WIDE)
    }

    fn with_gripper(opening: &gripper::Opening) -> Self {
        let mut hand = gripper::mesh(opening);
        hand.append(&Mesh::cylinder(0.045, -0.12, 0.0, SEGMENTS));
        Self {
            hand,
            links: forearm(),
            wall_x_m: Some(WALL_X_M),
        }
    }
}

/// About 1.5 m in front of the head's camera.
const WALL_X_M: f64 = 1.7;
const SEGMENTS: usize = 48;

/// Coarse cylinders round the forearm's axes; lengths between the joints are those of Baxter's URDF.
fn forearm() -> Vec<Link> {
    let upper = Mesh::cylinder(0.055, 0.0, 0.27, SEGMENTS);
    // Joint w1 turns about this link's z: its housing lies across the arm.
    let lower = Mesh::cylinder(0.052, -0.06, 0.06, SEGMENTS);
    vec![
        Link {
            frame: "left_upper_forearm".to_owned(),
            mesh: upper,
        },
        Link {
            frame: "left_lower_forearm".to_owned(),
            mesh: lower,
        },
    ]
}
