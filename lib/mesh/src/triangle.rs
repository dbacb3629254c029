//! Areas and normals.

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

/// Area normal of a triangle: perpendicular to it on its front side, with a length of twice its area.
#[inline]
pub fn area_normal([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Area of a triangle, in the square of the unit of its corners.
#[inline]
pub fn area(corners: [Point3<f64>; 3]) -> f64 {
    0.5 * area_normal(corners).norm()
}

/// Unit normal of a triangle's front side; zero where it has no area.
#[inline]
pub fn normal(corners: [Point3<f64>; 3]) -> Vector3<f64> {
    area_normal(corners).try_normalize(0.0).unwrap_or_default()
}

/// Largest cotangent: that of 0.006°. A triangle without area has no more.
pub const COTANGENT_MAX: f64 = 1e4;

/// Cotangent of a triangle's angle at its first corner, at most 10,000 in magnitude; 0 where a side there has no length.
#[inline]
pub fn cotangent([a, b, c]: [Point3<f64>; 3]) -> f64 {
    let (from, to) = (b - a, c - a);
    let (along, across) = (from.dot(&to), from.cross(&to).norm());
    if along.abs() < COTANGENT_MAX * across {
        along / across
    } else if along == 0.0 {
        0.0
    } else {
        COTANGENT_MAX.copysign(along)
    }
}

/// Cotangents of all its angles.
pub fn cotangents([a, b, c]: [Point3<f64>; 3]) -> [f64; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].map(cotangent)
}

/// The parts of a triangle's area that lie in the Voronoi cells of its corners; where an angle is obtuse, half of it for that corner
/// and a quarter for the others (Meyer, Desbrun, Schröder and Barr, "Discrete differential-geometry operators for triangulated
/// 2-manifolds", 2003). Their sum is its area.
pub fn voronoi_areas(corners: [Point3<f64>; 3]) -> [f64; 3] {
    let cotangents = cotangents(corners);
    if let Some(obtuse) = cotangents.iter().position(|&cotangent| cotangent < 0.0) {
        let area = area(corners);
        return [0, 1, 2].map(|k| if k == obtuse { 0.5 * area } else { 0.25 * area });
    }
    // The angle opposite to a side decides how much of it counts.
    let opposite = |k: usize| {
        let side = corners[(k + 1) % 3] - corners[(k + 2) % 3];
        cotangents[k] * side.norm_squared()
    };
    [0, 1, 2].map(|k| (opposite((k + 1) % 3) + opposite((k + 2) % 3)) / 8.0)
}

/// Unit normal of each vertex: the mean of the normals of its triangles, weighted by their angles there (Thürmer and
/// Wüthrich, J. Graphics Tools, 1998). Zero for a vertex without a triangle.
///
/// # Panics
/// If a triangle names a vertex that does not exist.
pub fn vertex_normals(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); vertices.len()];
    for triangle in triangles {
        let corners = triangle.map(|index| vertices[index as usize]);
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|step| corners[(k + step) % 3]);
            let across = area_normal([a, b, c]);
            let angle_rad = across.norm().atan2((b - a).dot(&(c - a)));
            let normal = across.try_normalize(0.0).unwrap_or_default();
            normals[triangle[k] as usize] += angle_rad * normal;
        }
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(0.0).unwrap_or_default();
    }
    normals
}

impl Mesh {
    /// Positions of a triangle's corners, in metres.
    ///
    /// # Panics
    /// If a corner names a vertex that does not exist.
    #[inline]
    pub fn corners(&self, triangle: &[u32; 3]) -> [Point3<f64>; 3] {
        triangle.map(|index| self.vertices[index as usize].cast())
    }

    /// Area of the whole surface, in square metres.
    pub fn area_m2(&self) -> f64 {
        let corners = self.triangles.iter().map(|t| self.corners(t));
        corners.map(area).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cuboid_has_its_area_and_its_corners_look_outward() {
        let cuboid = Mesh::cuboid(Point3::origin(), Point3::new(1.0, 2.0, 3.0));
        assert!((cuboid.area_m2() - 22.0).abs() < 1e-9);
        let vertices: Vec<Point3<f64>> = cuboid.vertices.iter().map(|v| v.cast()).collect();
        for (vertex, normal) in vertices
            .iter()
            .zip(vertex_normals(&vertices, &cuboid.triangles))
        {
            // Three faces meet at right angles, each a right angle or two halves of one.
            let outward = (vertex - Point3::new(0.5, 1.0, 1.5))
                .map(f64::signum)
                .normalize();
            assert!((normal - outward).norm() < 1e-6, "{vertex}: {normal}");
        }
    }

    #[test]
    fn cells_of_corners_share_a_triangles_area() {
        let triangle =
            |apex: [f64; 2]| [[0.0, 0.0], [2.0, 0.0], apex].map(|[x, y]| Point3::new(x, y, 0.5));
        // Right-angled at the origin: its cell reaches to the middle of the long side.
        let right = triangle([0.0, 2.0]);
        assert!((cotangents(right)[0]).abs() < 1e-12 && (cotangents(right)[1] - 1.0).abs() < 1e-12);
        for (found, expected) in voronoi_areas(right).into_iter().zip([1.0, 0.5, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{found}");
        }
        let obtuse = triangle([-1.0, 0.5]);
        assert!(cotangents(obtuse)[0] < 0.0);
        assert_eq!(voronoi_areas(obtuse), [0.25, 0.125, 0.125]);
        for corners in [right, obtuse, triangle([1.0, 1.9])] {
            assert!((voronoi_areas(corners).iter().sum::<f64>() - area(corners)).abs() < 1e-12);
        }
        let flat = triangle([1.0, 0.0]);
        assert!(
            cotangents(flat)
                .iter()
                .all(|cotangent| cotangent.is_finite())
        );
    }

    #[test]
    fn what_has_no_area_has_no_normal() {
        let points = [0.0, 1.0, 2.0].map(|x| Point3::new(x, 0.0, 0.0));
        assert_eq!(normal(points), Vector3::zeros());
        assert_eq!(vertex_normals(&points, &[]), [Vector3::zeros(); 3]);
    }
}
