//! The inner wall of a vessel, which follows its outer wall.

use cloud::Tree;
use mesh::{Mesh, triangle};
use nalgebra::{Matrix3, Point3, Vector3};

use super::Grasps;

#[cfg(test)]
mod tests;

/// Largest cosine between the normals of two walls that lie back to back.
const BACK_TO_BACK_MAX: f64 = -0.7;

/// Which vertices are the inner side of a thin wall, and where on the outer side each is.
///
/// If ARAP deformed both walls, an inner wall a millimetre behind the outer one would pass through it at the rim of a
/// dent. Instead each vertex of the inner wall keeps its distance from the deformed outer wall.
pub(crate) struct Lining {
    triangles: Vec<[u32; 3]>,
    rides: Vec<Ride>,
}

/// A vertex of the inner wall, bound to a point of a triangle of the outer wall.
struct Ride {
    vertex: u32,
    triangle: [u32; 3],
    /// Barycentric coordinates of the triangle's point nearest to the vertex at rest.
    weights: [f64; 3],
    /// From that point to the vertex, along the weighted normal of the corners.
    behind_m: f64,
    /// Remaining offset from there to the vertex, in the triangle's frame.
    aside_m: Vector3<f64>,
}

impl Lining {
    /// Finds walls up to `wall_max_m` thick among the vertices that may move.
    pub fn new(mesh: &Mesh, grasps: &Grasps, wall_max_m: f64) -> Self {
        let all = 0..mesh.vertices.len() as u32;
        let outer: Vec<u32> = all
            .filter(|&vertex| outwardness(grasps, vertex) > 0.0)
            .collect();
        let places: Vec<Point3<f32>> = outer.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let mut around = vec![Vec::new(); mesh.vertices.len()];
        let is_outer = |v: &u32| outer.binary_search(v).is_ok();
        for triangle in mesh
            .triangles
            .iter()
            .filter(|triangle| triangle.iter().all(is_outer))
        {
            triangle
                .iter()
                .for_each(|&v| around[v as usize].push(*triangle));
        }
        let inner = grasps
            .region
            .iter()
            .filter(|&&vertex| outwardness(grasps, vertex) < 0.0);
        let rides = Tree::new(&places).map_or_else(Vec::new, |tree| {
            let ride = |&vertex: &u32| {
                let nearest = tree.nearest(&mesh.vertices[vertex as usize]).index;
                let near = &around[outer[nearest] as usize];
                Ride::new(grasps, vertex, near).filter(|ride| -ride.behind_m <= wall_max_m)
            };
            inner.filter_map(ride).collect()
        });
        Self {
            triangles: mesh.triangles.clone(),
            rides,
        }
    }

    /// Moves the inner wall's vertices behind the deformed outer wall.
    pub fn lay(&self, vertices_m: &mut [Point3<f64>]) {
        if self.rides.is_empty() {
            return;
        }
        let normals = mesh::vertex_normals(vertices_m, &self.triangles);
        for ride in &self.rides {
            vertices_m[ride.vertex as usize] = ride.place(vertices_m, &normals);
        }
    }
}

impl Ride {
    /// On the nearest of the triangles that lie back to back with the vertex.
    fn new(grasps: &Grasps, vertex: u32, near: &[[u32; 3]]) -> Option<Self> {
        let (vertices_m, normals) = (&grasps.surface.vertices_m, &grasps.surface.normals);
        let place = vertices_m[vertex as usize];
        let rides = near.iter().map(|&triangle| {
            let weights = nearest_weights(&triangle.map(|v| vertices_m[v as usize]), &place);
            let mut ride = Self {
                vertex,
                triangle,
                weights,
                behind_m: 0.0,
                aside_m: Vector3::zeros(),
            };
            let way = place - ride.place(vertices_m, normals);
            let normal = ride.normal(normals);
            ride.behind_m = way.dot(&normal);
            ride.aside_m = ride
                .frame(vertices_m)
                .tr_mul(&(way - ride.behind_m * normal));
            (way.norm_squared(), ride)
        });
        let nearest = rides
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, ride)| ride)?;
        let facing = nearest.normal(normals).dot(&normals[vertex as usize]);
        (facing < BACK_TO_BACK_MAX && nearest.behind_m < 0.0).then_some(nearest)
    }

    fn place(&self, vertices_m: &[Point3<f64>], normals: &[Vector3<f64>]) -> Point3<f64> {
        let corners = self.triangle.iter().zip(self.weights);
        let point: Vector3<f64> = corners
            .map(|(&v, weight)| weight * vertices_m[v as usize].coords)
            .sum();
        let behind = self.behind_m * self.normal(normals);
        Point3::from(point + behind + self.frame(vertices_m) * self.aside_m)
    }

    fn normal(&self, normals: &[Vector3<f64>]) -> Vector3<f64> {
        let corners = self.triangle.iter().zip(self.weights);
        let sum: Vector3<f64> = corners
            .map(|(&v, weight)| weight * normals[v as usize])
            .sum();
        sum.try_normalize(0.0).unwrap_or_default()
    }

    /// Axes along the first edge, across it in the triangle, and out of it.
    fn frame(&self, vertices_m: &[Point3<f64>]) -> Matrix3<f64> {
        let corners = self.triangle.map(|v| vertices_m[v as usize]);
        let along = (corners[1] - corners[0])
            .try_normalize(0.0)
            .unwrap_or_default();
        let out = triangle::normal(corners);
        Matrix3::from_columns(&[along, out.cross(&along), out])
    }
}

/// Positive where the surface faces away from the long axis, negative where it faces it.
fn outwardness(grasps: &Grasps, vertex: u32) -> f64 {
    let from_centre = grasps.surface.vertices_m[vertex as usize] - grasps.centre;
    let along = from_centre.dot(&grasps.axis) * grasps.axis.into_inner();
    grasps.surface.normals[vertex as usize].dot(&(from_centre - along))
}

/// Barycentric coordinates of a triangle's point near to another point: its foot on the triangle's plane, with negative
/// coordinates set to 0 and the rest rescaled.
fn nearest_weights([a, b, c]: &[Point3<f64>; 3], point: &Point3<f64>) -> [f64; 3] {
    let across = triangle::area_normal([*a, *b, *c]);
    let area_sq = across.norm_squared();
    if area_sq == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let share = |from: &Point3<f64>, to: &Point3<f64>| {
        ((to - from).cross(&(point - from)).dot(&across) / area_sq).max(0.0)
    };
    let weights = [share(b, c), share(c, a), share(a, b)];
    let sum: f64 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}
