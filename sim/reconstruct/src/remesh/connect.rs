//! A surface whose edges can be split, collapsed and turned.

use nalgebra::{Point3, Vector3};

use crate::edges::sides;
use crate::poisson::Surface;

/// Least cosine between a triangle's normals before and after a change.
const TURN_COSINE_MIN: f64 = 0.3;

/// Triangles, and which of them are at each vertex. What was removed stays as a gap.
pub(super) struct Connected {
    pub points: Vec<Point3<f64>>,
    triangles: Vec<Option<[u32; 3]>>,
    at: Vec<Vec<u32>>,
    /// Whether a vertex lies on an edge with one triangle; nothing done here changes that.
    on_boundary: Vec<bool>,
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

    /// The triangles that are left, with the vertices that they use.
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

    fn corners(&self, triangle: u32) -> [u32; 3] {
        // Only triangles that exist are listed at a vertex.
        self.triangles[triangle as usize].unwrap_or_default()
    }

    fn triangles_on(&self, a: u32, b: u32) -> impl Iterator<Item = u32> {
        let at = self.at[a as usize].iter().copied();
        at.filter(move |&triangle| self.corners(triangle).contains(&b))
    }

    pub fn has_edge(&self, a: u32, b: u32) -> bool {
        self.triangles_on(a, b).next().is_some()
    }

    /// The vertices next to one, and whether the edge to each has one triangle only.
    fn ring(&self, vertex: u32) -> Vec<(u32, bool)> {
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

    /// The vertices that one slides between: its neighbours, on a boundary the two along it.
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

    fn area_normal(&self, corners: [u32; 3]) -> Vector3<f64> {
        let [a, b, c] = corners.map(|corner| self.points[corner as usize]);
        (b - a).cross(&(c - a))
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

    /// Puts a vertex on an edge.
    pub fn split(&mut self, [a, b]: [u32; 2], place: Point3<f64>) {
        let middle = self.points.len() as u32;
        let on: Vec<u32> = self.triangles_on(a, b).collect();
        self.points.push(place);
        self.at.push(Vec::with_capacity(6));
        self.on_boundary.push(on.len() == 1);
        for triangle in on {
            let corners = self.corners(triangle);
            let with = |old: u32| corners.map(|corner| if corner == old { middle } else { corner });
            let added = self.triangles.len() as u32;
            self.triangles.push(Some(with(a)));
            self.triangles[triangle as usize] = Some(with(b));
            for corner in with(a).into_iter().filter(|&corner| corner != b) {
                self.at[corner as usize].push(added);
            }
            self.at[middle as usize].push(triangle);
            self.at[b as usize].retain(|&at| at != triangle);
            self.at[b as usize].push(added);
        }
    }

    /// Makes one vertex of an edge's two, unless that would fold or pinch the surface or make an edge longer than
    /// `longest`.
    pub fn collapse(&mut self, a: u32, b: u32, longest: f64) -> bool {
        let (boundary_a, boundary_b) = (self.is_boundary(a), self.is_boundary(b));
        let on: Vec<u32> = self.triangles_on(a, b).collect();
        // Two vertices of a boundary joined across the surface would pinch it.
        if boundary_a && boundary_b && on.len() == 2 {
            return false;
        }
        let (ring_a, ring_b) = (self.ring(a), self.ring(b));
        let shared: Vec<u32> = ring_a
            .iter()
            .filter(|(other, _)| ring_b.iter().any(|(of_b, _)| of_b == other))
            .map(|(other, _)| *other)
            .collect();
        if shared.len() != on.len() || shared.iter().any(|&other| self.valence(other) <= 3) {
            return false;
        }
        let place = match (boundary_a, boundary_b) {
            (true, false) => self.points[a as usize],
            (false, true) => self.points[b as usize],
            _ => nalgebra::center(&self.points[a as usize], &self.points[b as usize]),
        };
        let is_long =
            |&(other, _): &(u32, bool)| (self.points[other as usize] - place).norm() > longest;
        if ring_a
            .iter()
            .chain(&ring_b)
            .any(|near| near.0 != a && near.0 != b && is_long(near))
            || self.folds(a, b, place)
            || self.folds(b, a, place)
        {
            return false;
        }
        self.join(a, b, &on, place);
        true
    }

    /// Whether moving a vertex turns one of its triangles too far; those with `other` vanish.
    fn folds(&self, vertex: u32, other: u32, place: Point3<f64>) -> bool {
        self.at[vertex as usize].iter().any(|&triangle| {
            let corners = self.corners(triangle);
            if corners.contains(&other) {
                return false;
            }
            let before = self.area_normal(corners);
            let [p, q, r] = corners.map(|corner| {
                if corner == vertex {
                    place
                } else {
                    self.points[corner as usize]
                }
            });
            let after = (q - p).cross(&(r - p));
            after.dot(&before) <= TURN_COSINE_MIN * after.norm() * before.norm()
        })
    }

    fn join(&mut self, a: u32, b: u32, vanishing: &[u32], place: Point3<f64>) {
        for &triangle in vanishing {
            for corner in self.corners(triangle) {
                self.at[corner as usize].retain(|&at| at != triangle);
            }
            self.triangles[triangle as usize] = None;
        }
        for triangle in std::mem::take(&mut self.at[b as usize]) {
            let corners = self.corners(triangle);
            self.triangles[triangle as usize] =
                Some(corners.map(|corner| if corner == b { a } else { corner }));
            self.at[a as usize].push(triangle);
        }
        self.points[a as usize] = place;
        self.on_boundary[a as usize] |= self.on_boundary[b as usize];
    }

    /// Replaces the edge from `a` to `b` by that between the third vertices, unless that folds the surface.
    pub fn turn(&mut self, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
        let on: Vec<u32> = self.triangles_on(a, b).collect();
        let [first, second] = on[..] else {
            return false;
        };
        if self.has_edge(c, d) || c == d {
            return false;
        }
        let pair = [[a, d, c], [d, b, c]];
        let normal = (self.area_normal(self.corners(first))
            + self.area_normal(self.corners(second)))
        .try_normalize(0.0)
        .unwrap_or_default();
        let is_folded = |corners: &[u32; 3]| {
            let after = self.area_normal(*corners);
            after.dot(&normal) <= 2.0 * TURN_COSINE_MIN * after.norm()
        };
        if pair.iter().any(is_folded) {
            return false;
        }
        for (triangle, corners) in [first, second].into_iter().zip(pair) {
            for corner in self.corners(triangle) {
                self.at[corner as usize].retain(|&at| at != triangle);
            }
            self.triangles[triangle as usize] = Some(corners);
            for corner in corners {
                self.at[corner as usize].push(triangle);
            }
        }
        true
    }

    /// Moves vertices, but each only if no triangle at it folds.
    pub fn move_unfolded(&mut self, places: &[Point3<f64>]) {
        for (vertex, &place) in places.iter().enumerate() {
            if !self.at[vertex].is_empty() && !self.folds(vertex as u32, u32::MAX, place) {
                self.points[vertex] = place;
            }
        }
    }
}
