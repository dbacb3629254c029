//! The world in front of the camera.

use gripper::HandKind;
use mesh::Mesh;
use nalgebra::Translation3;

use crate::gripper as electric;
use crate::gripper::Opening;
use crate::reflex;

/// Height in the hand's frame at which an object's bottom is: fingertips less 30 mm of grasp depth.
pub const OBJECT_BOTTOM_Z_M: f32 = electric::TIP_Z_M - electric::GRASP_DEPTH_M;

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
    /// The electric gripper closed on an upright object, given in its own frame (bottom centre, +z up).
    ///
    /// The object's axis is the hand's; the fingers close along y until they touch it.
    pub fn holding(object: &Mesh) -> Self {
        Self::with_fingers(HandKind::Electric, Some(object), None)
    }

    /// The electric gripper open and empty.
    pub fn empty_handed() -> Self {
        Self::with_fingers(HandKind::Electric, None, None)
    }

    /// A hand with its fingers `width_m` apart and the object, if any, between them. Fingers do not enter an object; without
    /// a width they touch it, or are open where there is none.
    pub fn with_fingers(kind: HandKind, object: Option<&Mesh>, width_m: Option<f32>) -> Self {
        let touching = object.map(electric::opening_for);
        let opening = match (touching, width_m) {
            (None, None) => Opening::WIDE,
            (None, Some(width_m)) => Opening::WIDE.widened(width_m),
            (Some(touching), None) => touching,
            (Some(touching), Some(width_m)) => touching.widened(width_m.max(touching.width_m())),
        };
        let mut hand = match kind {
            HandKind::Electric => electric::mesh(&opening),
            HandKind::Reflex => reflex::mesh(&opening),
        };
        hand.append(&Mesh::cylinder(0.045, -0.12, 0.0, SEGMENTS));
        if let Some(object) = object {
            let hand_from_object = Translation3::new(0.0, 0.0, OBJECT_BOTTOM_Z_M).into();
            hand.append(&object.transformed(&hand_from_object));
        }
        Self {
            hand,
            links: forearm(),
            wall_x_m: Some(WALL_X_M),
        }
    }

    /// How far apart fingers are that touch the object, m.
    pub fn grasp_width_m(object: &Mesh) -> f32 {
        electric::opening_for(object).width_m()
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
        let electric = |object, width_m| Scene::with_fingers(HandKind::Electric, object, width_m);
        for width_m in [width_m, 0.054] {
            assert_eq!(electric(Some(&can), Some(width_m)), Scene::holding(&can));
        }
        let open = electric(Some(&can), Some(0.0957));
        let wider_m = reach_m(&open) - reach_m(&Scene::holding(&can));
        assert!(
            (wider_m - (0.0957 - width_m) / 2.0).abs() < 1e-5,
            "{wider_m}"
        );
        let empty = electric(None, Some(0.1));
        assert_eq!(empty, Scene::empty_handed());
    }
}
