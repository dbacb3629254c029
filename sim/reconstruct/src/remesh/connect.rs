//! A triangle mesh whose connectivity can change.

use mesh::{sides, triangle};
use nalgebra::{Point3, Vector3};

use crate::poisson::Surface;

/// Triangles, and a list of those at each vertex. A removed triangle leaves `None` in its place.
pub(super) struct Connected {
    pub points: Vec<Point3<f64>>,
    pub(super) triangles: Vec<Option<[u32; 3]>>,
    pub(super) at: Vec<Vec<u32>>,
    /// Whether a vertex lies on the boundary, an edge with only one triangle; no operation changes that.
    pub(super) on_boundary: Vec<bool>,
}

impl Connected {
    pub fn new(surface: Surface) -> Self {
        let mut at = vec![Vec::new(); surface.points.len()];
        for (index, corners) in surface.triangles.iter().enumerate() {
            for &corner in corners {
                at[corner as usize].push(index as u32);
            }
        }
        let mut connected = Self {
            on_boundary: vec![false; surface.points.len()],
            points: surface.points,
            triangles: surface.triangles.into_iter().map(Some).collect(),
            at,
        };
        connected.on_boundary = (0..connected.points.len() as u32)
            .map(|vertex| {
                connected
                    .ring(vertex)
                    .iter()
                    .any(|&(_, is_boundary)| is_boundary)
            })
            .collect();
        connected
    }

    /// The remaining triangles, with the vertices that they use.
    pub fn into_surface(self) -> Surface {
        let mut new_index = vec![0; self.points.len()];
        let mut points = Vec::new();
        for (index, point) in self.points.iter().enumerate() {
            new_index[index] = points.len() as u32;
            if !self.at[index].is_empty() {
                points.push(*point);
            }
        }
        let triangles = self.triangles.into_iter().flatten();
        Surface {
            points,
            triangles: triangles
                .map(|corners| corners.map(|corner| new_index[corner as usize]))
                .collect(),
        }
    }

    pub fn vertex_count(&self) -> usize {
        self.at.iter().filter(|at| !at.is_empty()).count()
    }

    pub fn length(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm()
    }

    /// All edges.
    pub fn edges(&self) -> impl Iterator<Item = [u32; 2]> {
        let directed = self
            .triangles
            .iter()
            .flatten()
            .flat_map(|&corners| sides(corners));
        // Each edge once: from its smaller end, or in the one direction that a boundary's has.
        let is_wanted = |&(from, to): &(u32, u32)| {
            from < to
                || self.is_boundary(from)
                    && self.is_boundary(to)
                    && self.triangles_on(from, to).count() == 1
        };
        directed.filter(is_wanted).map(|(from, to)| [from, to])
    }

    /// The edges whose length is wanted, shortest first.
    pub fn edges_by_length(&self, is_wanted: impl Fn(f64) -> bool) -> Vec<[u32; 2]> {
        let with_length = self.edges().map(|[a, b]| (self.length(a, b), [a, b]));
        let mut edges: Vec<_> = with_length
            .filter(|&(length, _)| is_wanted(length))
            .collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        edges.into_iter().map(|(_, edge)| edge).collect()
    }

    pub(super) fn corners(&self, triangle: u32) -> [u32; 3] {
        // Only triangles that exist are listed at a vertex.
        self.triangles[triangle as usize].unwrap_or_default()
    }

    pub(super) fn triangles_on(&self, a: u32, b: u32) -> impl Iterator<Item = u32> {
        let at = self.at[a as usize].iter().copied();
        at.filter(move |&triangle| self.corners(triangle).contains(&b))
    }

    pub fn has_edge(&self, a: u32, b: u32) -> bool {
        self.triangles_on(a, b).next().is_some()
    }

    /// The vertices next to one, and whether the edge to each has one triangle only.
    pub(super) fn ring(&self, vertex: u32) -> Vec<(u32, bool)> {
        let mut ring: Vec<(u32, bool)> = Vec::with_capacity(8);
        for &triangle in &self.at[vertex as usize] {
            for corner in self
                .corners(triangle)
                .into_iter()
                .filter(|&corner| corner != vertex)
            {
                match ring.iter_mut().find(|(other, _)| *other == corner) {
                    Some((_, is_boundary)) => *is_boundary = false,
                    None => ring.push((corner, true)),
                }
            }
        }
        ring
    }

    pub fn is_boundary(&self, vertex: u32) -> bool {
        self.on_boundary[vertex as usize]
    }

    /// Number of edges at a vertex.
    pub fn valence(&self, vertex: u32) -> usize {
        self.at[vertex as usize].len() + usize::from(self.is_boundary(vertex))
    }

    /// The vertices whose centroid tangential relaxation moves this one towards: its one-ring, or on a boundary its two
    /// neighbours along that.
    pub fn smoothing_ring(&self, vertex: u32) -> Vec<u32> {
        let ring = self.ring(vertex);
        let is_boundary = self.is_boundary(vertex);
        let wanted = ring
            .into_iter()
            .filter(|&(_, on_boundary)| on_boundary == is_boundary);
        wanted.map(|(other, _)| other).collect()
    }

    /// Mean normal of the triangles at a vertex, by area.
    pub fn normal(&self, vertex: u32) -> Vector3<f64> {
        let sum: Vector3<f64> = self.at[vertex as usize]
            .iter()
            .map(|&triangle| self.area_normal(self.corners(triangle)))
            .sum();
        sum.try_normalize(0.0).unwrap_or_default()
    }

    pub(super) fn area_normal(&self, corners: [u32; 3]) -> Vector3<f64> {
        triangle::area_normal(corners.map(|corner| self.points[corner as usize]))
    }

    /// The third vertices of an inner edge's two triangles, the first of the one that runs from `a` to `b`.
    pub fn opposite(&self, a: u32, b: u32) -> Option<[u32; 2]> {
        let mut on = self.triangles_on(a, b);
        let (first, second) = (self.corners(on.next()?), self.corners(on.next()?));
        let third = |corners: [u32; 3]| {
            corners
                .into_iter()
                .find(|&corner| corner != a && corner != b)
        };
        let runs_along = |corners: [u32; 3]| sides(corners).contains(&(a, b));
        if runs_along(first) {
            Some([third(first)?, third(second)?])
        } else {
            Some([third(second)?, third(first)?])
        }
    }
}
