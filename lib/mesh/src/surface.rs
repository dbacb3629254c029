//! Points on a mesh's surface.

use nalgebra::Point3;
use rand::{Rng, RngExt};

use crate::mesh::Mesh;
use crate::triangle;

impl Mesh {
    /// `count` random points, uniform over the surface's area. None for a mesh without area.
    pub fn surface_points(&self, count: usize, random: &mut impl Rng) -> Vec<Point3<f32>> {
        let mut total_m2 = 0.0;
        let areas_m2: Vec<f64> = self
            .triangles
            .iter()
            .map(|triangle| {
                total_m2 += triangle::area(self.corners(triangle));
                total_m2
            })
            .collect();
        if !(total_m2 > 0.0 && total_m2.is_finite()) {
            return Vec::new();
        }
        (0..count)
            .map(|_| {
                let place_m2 = random.random_range(0.0..total_m2);
                let index = areas_m2.partition_point(|&end_m2| end_m2 <= place_m2);
                let [a, b, c] = self.corners(&self.triangles[index]);
                let (mut u, mut v): (f64, f64) = (random.random(), random.random());
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                (a + u * (b - a) + v * (c - a)).cast()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn points_lie_on_the_surface_as_its_area_is_spread() {
        let cuboid = Mesh::cuboid(Point3::origin(), Point3::new(1.0, 1.0, 3.0));
        let points = cuboid.surface_points(14_000, &mut Pcg64Mcg::seed_from_u64(1));
        let near = |value: f32, end: f32| (value - end).abs() < 1e-6;
        let at_end = |p: &&Point3<f32>| near(p.z, 0.0) || near(p.z, 3.0);
        let on_surface = |p: &Point3<f32>| {
            at_end(&p) || [p.x, p.y].iter().any(|&v| near(v, 0.0) || near(v, 1.0))
        };
        assert!(points.iter().all(on_surface));
        // Two of fourteen square metres; four standard deviations are 166.
        let ends = points.iter().filter(at_end).count();
        assert!((1834..=2166).contains(&ends), "{ends} of 14000");
    }

    #[test]
    fn no_area_has_no_points() {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        assert!(Mesh::default().surface_points(5, &mut random).is_empty());
        let flat = Mesh {
            vertices: vec![Point3::origin(); 3],
            triangles: vec![[0, 1, 2]],
        };
        assert!(flat.surface_points(5, &mut random).is_empty());
    }
}
