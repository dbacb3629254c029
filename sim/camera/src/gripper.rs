//! Baxter's electric gripper with its standard fingers, coarsely.

use nalgebra::Point3;

use mesh::Mesh;

/// Height of the fingertips in the hand's frame.
pub(crate) const TIP_Z_M: f32 = 0.1577;
/// How far the fingers overlap the object.
pub(crate) const GRASP_DEPTH_M: f32 = 0.030;

const BASE_RADIUS_M: f32 = 0.029;
const BASE_TOP_Z_M: f32 = 0.100;
/// Paddle along x (width), y (thickness) and z (length).
const PADDLE_M: [f32; 3] = [0.042, 0.0065, 0.037];
/// Bar that carries a paddle, along x and y.
const BAR_M: [f32; 2] = [0.014, 0.009];
/// Slide on top of the base, along x and z.
const SLIDE_M: [f32; 2] = [0.024, 0.012];

/// Where the two paddles' inner faces are, along y in the hand's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Opening {
    pub(crate) y_min_m: f32,
    pub(crate) y_max_m: f32,
}

impl Opening {
    pub(crate) const WIDE: Opening = Opening {
        y_min_m: -0.05,
        y_max_m: 0.05,
    };

    pub(crate) fn width_m(&self) -> f32 {
        self.y_max_m - self.y_min_m
    }

    /// So wide about the same middle.
    pub(crate) fn widened(&self, width_m: f32) -> Opening {
        let middle_m = 0.5 * (self.y_min_m + self.y_max_m);
        Opening {
            y_min_m: middle_m - 0.5 * width_m,
            y_max_m: middle_m + 0.5 * width_m,
        }
    }
}

/// Extent along y of the part of an object (in its own frame) that is between the paddles.
pub(crate) fn opening_for(object: &Mesh) -> Opening {
    let between = |v: &&Point3<f32>| v.z <= GRASP_DEPTH_M && v.x.abs() <= 0.5 * PADDLE_M[0];
    let closed = Opening {
        y_min_m: 0.0,
        y_max_m: 0.0,
    };
    object
        .vertices
        .iter()
        .filter(between)
        .fold(closed, |opening, v| Opening {
            y_min_m: opening.y_min_m.min(v.y),
            y_max_m: opening.y_max_m.max(v.y),
        })
}

/// Base, slides, bars and paddles in the hand's frame.
pub(crate) fn mesh(opening: &Opening) -> Mesh {
    let mut mesh = Mesh::cylinder(BASE_RADIUS_M, 0.0, BASE_TOP_Z_M, 48);
    for (side, face_y_m) in [(-1.0, opening.y_min_m), (1.0, opening.y_max_m)] {
        let outer_y_m = face_y_m + side * PADDLE_M[1];
        let paddle_z_m = TIP_Z_M - PADDLE_M[2];
        mesh.append(&block(
            PADDLE_M[0],
            [face_y_m, outer_y_m],
            [paddle_z_m, TIP_Z_M],
        ));
        // The bar runs up outside the paddle, the slide carries it outward from the base.
        let bar_y_m = [outer_y_m, outer_y_m + side * BAR_M[1]];
        mesh.append(&block(BAR_M[0], bar_y_m, [BASE_TOP_Z_M, TIP_Z_M - 0.010]));
        mesh.append(&block(
            SLIDE_M[0],
            [0.0, bar_y_m[1]],
            [BASE_TOP_Z_M, BASE_TOP_Z_M + SLIDE_M[1]],
        ));
    }
    mesh
}

/// A block centred on x = 0.
fn block(width_m: f32, y_m: [f32; 2], z_m: [f32; 2]) -> Mesh {
    let min = Point3::new(-0.5 * width_m, y_m[0].min(y_m[1]), z_m[0]);
    let max = Point3::new(0.5 * width_m, y_m[0].max(y_m[1]), z_m[1]);
    Mesh::cuboid(min, max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_objects::{ObjectClass, Variation};

    #[test]
    fn the_paddles_touch_the_object_and_do_not_enter_it() {
        let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
        let opening = opening_for(&can);
        assert!((opening.y_max_m - 0.03275).abs() < 1e-5, "{opening:?}");
        assert!((opening.y_min_m + 0.03275).abs() < 1e-5, "{opening:?}");
        let (min, max) = mesh(&opening).bounds();
        assert!((max.z - TIP_Z_M).abs() < 1e-6 && min.z == 0.0);
        assert!((max.y - (0.03275 + 0.0065 + 0.009)).abs() < 1e-5);
    }

    #[test]
    fn parts_are_closed() {
        assert!(mesh(&Opening::WIDE).is_closed_manifold());
    }
}
