//! The vertices that one finger pad moves.

use nalgebra::{Unit, Vector3};

use super::surface::Surface;

/// Vertices under a pad, and how far the pad moves before it touches each.
pub(super) struct Pad {
    /// The handle first.
    pub vertices: Vec<u32>,
    /// Distance of each vertex from the pad when it touches the handle, m; at least 0.
    pub gaps_m: Vec<f64>,
    /// From the outer wall to the innermost wall that moves along, m; 0 for a single wall.
    pub thickness_m: f64,
}

/// A flat round pad that comes along `direction` and touches at `handle`.
pub(super) struct Press<'a> {
    pub surface: &'a Surface,
    /// Whether a vertex may move.
    pub is_free: &'a dyn Fn(u32) -> bool,
    pub handle: u32,
    pub direction: Unit<Vector3<f64>>,
    pub radius_m: f64,
    pub wall_max_m: f64,
}

impl Press<'_> {
    /// The outer wall under the pad, and a second wall close behind it (a cup has two): a finger bends both alike.
    pub fn pad(&self) -> Pad {
        let mut vertices = self.outer_wall();
        let mut gaps_m: Vec<f64> = vertices.iter().map(|&v| self.depth_m(v).max(0.0)).collect();
        let reach_m = gaps_m.iter().copied().fold(0.0, f64::max) + self.wall_max_m;
        let inner = self.inner_wall(reach_m);
        let depths_m: Vec<f64> = inner.iter().map(|&v| self.depth_m(v)).collect();
        let thickness_m = depths_m.iter().copied().reduce(f64::min).unwrap_or(0.0);
        gaps_m.extend(depths_m.iter().map(|depth_m| depth_m - thickness_m));
        vertices.extend(inner);
        Pad {
            vertices,
            gaps_m,
            thickness_m,
        }
    }

    /// Vertices within the radius that face the finger, reached over such vertices from the handle.
    fn outer_wall(&self) -> Vec<u32> {
        let centre = self.surface.vertices_m[self.handle as usize];
        let is_under = |vertex: u32| {
            let offset = self.surface.vertices_m[vertex as usize] - centre;
            offset.norm() <= self.radius_m && self.facing(vertex) < 0.0 && (self.is_free)(vertex)
        };
        let mut found = vec![self.handle];
        let mut next = 0;
        while next < found.len() {
            for &vertex in self.surface.neighbours(found[next]) {
                if !found.contains(&vertex) && is_under(vertex) {
                    found.push(vertex);
                }
            }
            next += 1;
        }
        found
    }

    /// Vertices behind the pad that face away from the finger, no deeper than `reach_m`.
    fn inner_wall(&self, reach_m: f64) -> Vec<u32> {
        let is_behind = |&vertex: &u32| {
            let depth_m = self.depth_m(vertex);
            (0.0..=reach_m).contains(&depth_m)
                && self.aside_m(vertex, depth_m) <= self.radius_m
                && self.facing(vertex) > 0.0
                && (self.is_free)(vertex)
        };
        let all = 0..self.surface.vertices_m.len() as u32;
        all.filter(is_behind).collect()
    }

    fn facing(&self, vertex: u32) -> f64 {
        self.surface.normals[vertex as usize].dot(&self.direction)
    }

    /// How far the pad moves until it is level with the vertex.
    fn depth_m(&self, vertex: u32) -> f64 {
        self.offset(vertex).dot(&self.direction)
    }

    fn aside_m(&self, vertex: u32, depth_m: f64) -> f64 {
        (self.offset(vertex) - depth_m * self.direction.into_inner()).norm()
    }

    fn offset(&self, vertex: u32) -> Vector3<f64> {
        let vertices_m = &self.surface.vertices_m;
        vertices_m[vertex as usize] - vertices_m[self.handle as usize]
    }
}
