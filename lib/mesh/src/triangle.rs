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
    fn what_has_no_area_has_no_normal() {
        let points = [0.0, 1.0, 2.0].map(|x| Point3::new(x, 0.0, 0.0));
        assert_eq!(normal(points), Vector3::zeros());
        assert_eq!(vertex_normals(&points, &[]), [Vector3::zeros(); 3]);
    }
}
