//! The simulated camera's pinhole model. The centre of pixel (u, v) is at exactly (u, v).

pub use depth_threshold::Intrinsics;
use nalgebra::Point3;

/// Depth stream of one D435i at 848 x 480, as its driver reports it.
pub const D435I: Intrinsics = Intrinsics {
    fx: 418.265,
    fy: 418.265,
    cx: 424.158,
    cy: 238.240,
    width: 848,
    height: 480,
};

/// Image coordinates (u, v) of a point in the optical frame with positive z.
pub fn project(camera: &Intrinsics, point: &Point3<f64>) -> [f64; 2] {
    [
        camera.fx * point.x / point.z + camera.cx,
        camera.fy * point.y / point.z + camera.cy,
    ]
}

/// Point in the optical frame, in metres, that (u, v) shows at depth `z_m`.
pub fn deproject(camera: &Intrinsics, [u, v]: [f64; 2], z_m: f64) -> Point3<f64> {
    Point3::new(
        (u - camera.cx) / camera.fx * z_m,
        (v - camera.cy) / camera.fy * z_m,
        z_m,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_and_deprojection_are_inverse() {
        let [u, v] = project(&D435I, &deproject(&D435I, [100.5, 400.25], 0.7));
        assert!((u - 100.5).abs() < 1e-9 && (v - 400.25).abs() < 1e-9);
    }
}
