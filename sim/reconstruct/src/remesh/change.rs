//! The local operations of remeshing: edge split, edge collapse, edge flip, vertex move.

use mesh::triangle;
use nalgebra::Point3;

use super::connect::Connected;

/// An operation is refused if a triangle's normal before and after it have a smaller cosine (72.5°): the surface folds.
const COSINE_MIN: f64 = 0.3;

impl Connected {
    /// Edge split: inserts a vertex at `place` on an edge.
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

    /// Edge collapse: merges an edge's two vertices, unless that would fold or pinch the surface or make an edge longer
    /// than `longest`. Returns whether it did.
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
            let after = triangle::area_normal(corners.map(|corner| {
                if corner == vertex {
                    place
                } else {
                    self.points[corner as usize]
                }
            }));
            after.dot(&before) <= COSINE_MIN * after.norm() * before.norm()
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

    /// Edge flip: replaces the edge from `a` to `b` by the one between the opposite vertices `c` and `d`, unless that folds
    /// the surface. Returns whether it did.
    pub fn flip(&mut self, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
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
            after.dot(&normal) <= 2.0 * COSINE_MIN * after.norm()
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

    /// Moves each vertex to its entry of `places`, except where one of its triangles would fold.
    pub fn move_unfolded(&mut self, places: &[Point3<f64>]) {
        for (vertex, &place) in places.iter().enumerate() {
            if !self.at[vertex].is_empty() && !self.folds(vertex as u32, u32::MAX, place) {
                self.points[vertex] = place;
            }
        }
    }
}
