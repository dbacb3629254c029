//! Missing depth at one side of the object: shiny metal seen at a grazing angle gives the camera no depth.

use std::collections::HashMap;

use nalgebra::Point3;
use sim_camera::OBJECT_BOTTOM_Z_M;

use crate::setup::Setup;
use crate::view::View;

/// Height in the hand's frame above the fingertips, m: points above it belong to the object, not to the gripper.
const ABOVE_FINGERS_M: f64 = OBJECT_BOTTOM_Z_M as f64 + 0.032;
/// Height of the horizontal rows into which the object's points are binned to find its left and right edges, m.
const ROW_M: f32 = 0.002;

/// Removes from each view the object's points within a width (m) of its right edge, or of its left one where `side` is negative:
/// x of the optical frame.
pub fn lose_flank(views: &mut [View], setup: &Setup, side: f32, width_m: f32) {
    for (view, &wrist_rad) in views.iter_mut().zip(&setup.wrist_angles_rad) {
        let object = object_in(view, setup, wrist_rad);
        lose_side(view, &object, side, width_m);
    }
}

/// Which of a view's points are the object's: those above the fingers.
pub fn object_in(view: &View, setup: &Setup, wrist_rad: f64) -> Vec<bool> {
    let hand_from_camera = setup.camera_from_hand(wrist_rad).inverse();
    let is_object =
        |point: &Point3<f32>| (hand_from_camera * point.cast::<f64>()).z > ABOVE_FINGERS_M;
    view.points.iter().map(is_object).collect()
}

/// Row by row.
fn lose_side(view: &mut View, object: &[bool], side: f32, width_m: f32) {
    let row = |point: &Point3<f32>| (point.y / ROW_M).floor() as i32;
    let mut edges = HashMap::<i32, f32>::new();
    let own = view
        .points
        .iter()
        .zip(object)
        .filter(|(_, is_object)| **is_object);
    for (point, _) in own {
        let edge = edges.entry(row(point)).or_insert(f32::MIN);
        *edge = edge.max(side * point.x);
    }
    let mut is_object = object.iter();
    view.points.retain(|point| {
        let near = |edge: &f32| edge - side * point.x < width_m;
        !is_object.next().is_some_and(|&own| own) || !edges.get(&row(point)).is_some_and(near)
    });
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;

    use super::*;

    /// A wall 40 mm wide and 40 mm high, and a lower part that is no object.
    fn view() -> (View, Vec<bool>) {
        let places = (0..41).flat_map(|x| (0..61).map(move |y| [x, y]));
        let points: Vec<Point3<f32>> = places
            .map(|[x, y]| Point3::new(0.001 * x as f32 - 0.02, 0.001 * y as f32, 0.4))
            .collect();
        let object = points.iter().map(|point| point.y < 0.0395).collect();
        let view = View {
            points,
            believed_hand_from_camera: Isometry3::identity(),
        };
        (view, object)
    }

    #[test]
    fn a_lost_flank_is_as_wide_as_said_on_one_side_of_the_object_alone() {
        for side in [-1.0, 1.0] {
            let (mut view, object) = view();
            let all = view.points.len();
            lose_side(&mut view, &object, side, 0.0065);
            // Seven columns of 40 rows.
            assert_eq!(all - view.points.len(), 7 * 40);
            let kept = view.points.iter().filter(|point| point.y < 0.0395);
            let farthest = kept.map(|point| side * point.x).fold(f32::MIN, f32::max);
            assert!((farthest - 0.013).abs() < 1e-4, "{farthest}");
        }
    }
}
