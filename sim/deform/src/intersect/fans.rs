//! The triangles around each vertex.

use mesh::{HalfEdge, HalfEdges};
use nalgebra::{Point3, Unit, Vector3};

/// Which triangles are around each vertex of a mesh.
pub(super) struct Fans {
    half_edges: HalfEdges,
    /// Whether the triangles around each vertex close up, each edge between exactly two of them.
    is_closed: Vec<bool>,
}

impl Fans {
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let half_edges = HalfEdges::new(vertex_count, triangles);
        let is_closed = |vertex| {
            let sorted = |end: fn(&HalfEdge) -> u32| {
                let mut ends: Vec<u32> = half_edges.from(vertex).iter().map(end).collect();
                ends.sort_unstable();
                ends
            };
            let [out, back] = [sorted(|edge| edge.end), sorted(|edge| edge.apex)];
            out == back && out.windows(2).all(|pair| pair[0] != pair[1])
        };
        Self {
            is_closed: (0..vertex_count as u32).map(is_closed).collect(),
            half_edges,
        }
    }

    /// For each vertex, whether its triangles certainly do not intersect each other: projected along the vertex's normal
    /// they all face forward and go round once, so that each has a sector of its own.
    ///
    /// `normals`: area normals of the triangles (length: twice the area).
    pub fn are_plain(&self, vertices_m: &[Point3<f64>], normals: &[Vector3<f64>]) -> Vec<bool> {
        (0..vertices_m.len())
            .map(|vertex| self.is_plain(vertex, vertices_m, normals))
            .collect()
    }

    fn is_plain(
        &self,
        vertex: usize,
        vertices_m: &[Point3<f64>],
        normals: &[Vector3<f64>],
    ) -> bool {
        let fan = self.half_edges.from(vertex as u32);
        let of_triangle = |edge: &HalfEdge| normals[edge.triangle as usize];
        let sum: Vector3<f64> = fan.iter().map(of_triangle).sum();
        let Some(normal) = Unit::try_new(sum, 0.0) else {
            return false;
        };
        let aside = sum.cross(&Vector3::ith(sum.iamin(), 1.0));
        let height = |other: u32| (vertices_m[other as usize] - vertices_m[vertex]).dot(&aside);
        let mut rounds = 0;
        for edge in fan {
            let front = of_triangle(edge);
            // A margin above the rounding error of the product.
            if front.dot(&normal) <= 1e-6 * front.norm() {
                return false;
            }
            let [from, to] = [edge.end, edge.apex].map(height);
            rounds += i32::from(from < 0.0 && to >= 0.0);
        }
        self.is_closed[vertex] && rounds == 1
    }
}
