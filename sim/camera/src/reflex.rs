//! A ReFlex hand, coarsely: a palm, two fingers on one side and one opposite. Its measures are assumed; the fingertips are
//! where those of the electric gripper are, so that objects stand in it as deep.

use nalgebra::Point3;

use mesh::Mesh;

use crate::gripper::{Opening, TIP_Z_M};

/// Half the palm along x and y, and its height.
const PALM_M: [f32; 3] = [0.040, 0.045, 0.060];
/// A finger along x and y.
const FINGER_M: [f32; 2] = [0.020, 0.016];
/// Where the axes of the two fingers are along x; the opposite one is at 0.
const PAIR_X_M: f32 = 0.0276;
/// Thickness along z of what carries a finger.
const KNUCKLE_M: f32 = 0.012;

/// Palm and fingers in the hand's frame.
pub(crate) fn mesh(opening: &Opening) -> Mesh {
    let [half_x, half_y, palm_z] = PALM_M;
    let mut mesh = Mesh::cuboid(
        Point3::new(-half_x, -half_y, 0.0),
        Point3::new(half_x, half_y, palm_z),
    );
    for x_m in [-PAIR_X_M, PAIR_X_M] {
        append_finger(&mut mesh, x_m, opening.y_min_m, -1.0);
    }
    append_finger(&mut mesh, 0.0, opening.y_max_m, 1.0);
    mesh
}

/// A finger whose inner face is at `face_y_m`, outward in the direction `side`.
fn append_finger(mesh: &mut Mesh, x_m: f32, face_y_m: f32, side: f32) {
    let [width_m, thickness_m] = FINGER_M;
    let outer_y_m = face_y_m + side * thickness_m;
    let mut block = |y_m: [f32; 2], z_m: [f32; 2]| {
        let min = Point3::new(x_m - 0.5 * width_m, y_m[0].min(y_m[1]), z_m[0]);
        let max = Point3::new(x_m + 0.5 * width_m, y_m[0].max(y_m[1]), z_m[1]);
        mesh.append(&Mesh::cuboid(min, max));
    };
    let palm_z_m = PALM_M[2];
    block([face_y_m, outer_y_m], [palm_z_m, TIP_Z_M]);
    block([0.0, outer_y_m], [palm_z_m - KNUCKLE_M, palm_z_m]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingers_are_as_far_apart_as_they_are_said_to_be() {
        let opening = Opening::WIDE.widened(0.07);
        let mesh = mesh(&opening);
        assert!(mesh.is_closed_manifold());
        let above_palm = |v: &&Point3<f32>| v.z > PALM_M[2];
        let inner_m = mesh
            .vertices
            .iter()
            .filter(above_palm)
            .map(|v| v.y.abs())
            .fold(f32::INFINITY, f32::min);
        assert!((inner_m - 0.035).abs() < 1e-6, "{inner_m}");
        let (_, max) = mesh.bounds();
        assert!((max.z - TIP_Z_M).abs() < 1e-6);
    }
}
