//! The world in front of the camera.

use nalgebra::Translation3;

use crate::gripper;
use sim_objects::Mesh;

/// Height in the hand's frame at which an object's bottom is: fingertips less 30 mm of grasp depth.
pub const OBJECT_BOTTOM_Z_M: f32 = gripper::TIP_Z_M - gripper::GRASP_DEPTH_M;

/// A part of the arm that moves on its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// TF frame that it moves with, without the arm's side before it.
    pub frame: String,
    /// Its shape in that frame.
    pub mesh: Mesh,
}

/// Object, gripper, arm and wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Everything that moves with the hand, in its frame: gripper, wrist and object.
    pub hand: Mesh,
    /// Forearm.
    pub links: Vec<Link>,
    /// Where the wall stands, in Baxter's base; `None` for open space.
    pub wall_x_m: Option<f64>,
}

impl Scene {
    /// The gripper closed on an upright object, given in its own frame (bottom centre, +z up).
    ///
    /// The object's axis is the hand's; the fingers close along y until they touch it.
    pub fn holding(object: &Mesh) -> Self {
        Self::with_object(object, &gripper::opening_for(object))
    }

    /// The gripper with its fingers `width_m` apart and the object, if any, between them. Fingers do not enter an object.
    pub fn with_fingers(object: Option<&Mesh>, width_m: f32) -> Self {
        let Some(object) = object else {
            return Self::with_gripper(&gripper::Opening::WIDE.widened(width_m));
        };
        let touching = gripper::opening_for(object);
        let opening = touching.widened(width_m.max(touching.width_m()));
        Self::with_object(object, &opening)
    }

    /// How far apart fingers are that touch the object, m.
    pub fn grasp_width_m(object: &Mesh) -> f32 {
        gripper::opening_for(object).width_m()
    }

    /// The gripper open and empty.
    pub fn empty_handed() -> Self {
        Self::with_gripper(&gripper::Opening::WIDE)
    }

    fn with_object(object: &Mesh, opening: &gripper::Opening) -> Self {
        let mut scene = Self::with_gripper(opening);
        let hand_from_object = Translation3::new(0.0, 0.0, OBJECT_BOTTOM_Z_M).into();
        scene.hand.append(&object.transformed(&hand_from_object));
        scene
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
            frame: "upper_forearm".to_owned(),
            mesh: upper,
        },
        Link {
            frame: "lower_forearm".to_owned(),
            mesh: lower,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_objects::{ObjectClass, Variation};

    #[test]
    fn fingers_are_as_far_apart_as_they_are_said_to_be_but_not_in_the_object() {
        let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
        let reach_m = |scene: &Scene| scene.hand.bounds().1.y;
        let width_m = Scene::grasp_width_m(&can);
        assert!((width_m - 0.0655).abs() < 1e-4);
        assert_eq!(
            Scene::with_fingers(Some(&can), width_m),
            Scene::holding(&can)
        );
        assert_eq!(Scene::with_fingers(Some(&can), 0.054), Scene::holding(&can));
        let open = Scene::with_fingers(Some(&can), 0.0957);
        let wider_m = reach_m(&open) - reach_m(&Scene::holding(&can));
        assert!(
            (wider_m - (0.0957 - width_m) / 2.0).abs() < 1e-5,
            "{wider_m}"
        );
        let empty = Scene::with_fingers(None, 0.1);
        assert_eq!(empty, Scene::empty_handed());
    }
}
