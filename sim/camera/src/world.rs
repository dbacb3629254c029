//! What the camera looks at: the hand, and what it holds now.

use gripper::HandKind;
use mesh::Mesh;
use sim_camera::Scene;

/// A change of the fingers' distance below this is not worth drawing anew, m.
const WIDTH_CHANGE_MIN_M: f32 = 2e-4;

/// The hand, its fingers, and the object between them.
pub struct World {
    kind: HandKind,
    object: Option<Mesh>,
    /// Distance between the fingers, m; unknown until the gripper has spoken.
    width_m: Option<f32>,
    scene: Scene,
}

impl World {
    /// A hand of this kind, empty or with an object as it is held; the fingers touch the object.
    pub fn new(kind: HandKind, object: Option<Mesh>) -> Self {
        Self {
            scene: Scene::with_fingers(kind, object.as_ref(), None),
            kind,
            object,
            width_m: None,
        }
    }

    /// Takes the other world's object into the hand; the fingers stay where they were.
    pub fn hold(&mut self, other: Self) {
        self.object = other.object;
        self.draw();
    }

    /// Distance between fingers that touch the object, m; `None` for an empty hand.
    pub fn grasp_width_m(&self) -> Option<f64> {
        let width_m = self.object.as_ref().map(Scene::grasp_width_m);
        width_m.map(f64::from)
    }

    /// Moves the fingers to a distance (m). One that is not finite is ignored.
    pub fn set_width(&mut self, width_m: f64) {
        if !width_m.is_finite() {
            return;
        }
        let width_m = width_m as f32;
        let is_news = |old: f32| (old - width_m).abs() > WIDTH_CHANGE_MIN_M;
        if self.width_m.is_none_or(is_news) {
            self.width_m = Some(width_m);
            self.draw();
        }
    }

    fn draw(&mut self) {
        self.scene = Scene::with_fingers(self.kind, self.object.as_ref(), self.width_m);
    }

    pub fn scene(&self) -> &Scene {
        &self.scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_does_not_stop_the_fingers_for_good() {
        let mut world = World::new(HandKind::Electric, None);
        for width_m in [0.05, f64::NAN, f64::INFINITY] {
            world.set_width(width_m);
            assert_eq!(world.width_m, Some(0.05));
        }
        world.set_width(0.07);
        assert_eq!(world.width_m, Some(0.07));
    }
}
