//! Points on the surface of a mesh.

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::Mesh;

/// Points spread at random over the triangles, uniformly by area; none where there is no area.
pub fn surface(mesh: &Mesh, count: usize, seed: u64) -> Vec<Point3<f32>> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| mesh.vertices[corner as usize]);
    let mut area = 0.0;
    let up_to = mesh.triangles.iter().map(|triangle| {
        let [a, b, c] = corners(triangle);
        area += f64::from((b - a).cross(&(c - a)).norm());
        area
    });
    let up_to: Vec<f64> = up_to.collect();
    let whole = up_to.last().copied().unwrap_or(0.0);
    if !(whole.is_finite() && whole > 0.0) {
        return Vec::new();
    }
    let point = |_| {
        let area = random.random_range(0.0..whole);
        let chosen = up_to.partition_point(|&up_to| up_to <= area);
        let [a, b, c] = corners(&mesh.triangles[chosen.min(up_to.len() - 1)]);
        let (mut s, mut t): (f32, f32) = (random.random(), random.random());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        a + (b - a) * s + (c - a) * t
    };
    (0..count).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_on_the_surface_and_spread_by_area() {
        let (low, high) = (Point3::origin(), Point3::new(1.0, 1.0, 3.0));
        let points = surface(&Mesh::cuboid(low, high), 14_000, 3);
        let is_at = |value: f32, end: f32| (value - end).abs() < 1e-5;
        let is_end = |point: &&Point3<f32>| is_at(point.z, 0.0) || is_at(point.z, 3.0);
        // Of 14 parts of the area the two ends have one each.
        let ends = points.iter().filter(is_end).count();
        assert!((1800..2200).contains(&ends), "seed 3: {ends}");
        for point in &points {
            let on_side =
                (0..3).any(|axis| is_at(point[axis], 0.0) || is_at(point[axis], high[axis]));
            assert!(on_side, "seed 3: {point}");
        }
    }

    #[test]
    fn a_mesh_without_area_has_no_points() {
        let mut mesh = Mesh::cuboid(Point3::origin(), Point3::origin());
        assert!(surface(&mesh, 10, 1).is_empty());
        mesh.triangles.clear();
        assert!(surface(&mesh, 10, 1).is_empty());
    }
}
