//! Whether two triangles of a mesh pass through each other.

use nalgebra::{Point3, Vector3};
use robust::{Coord3D, orient3d};

use super::fans::Fans;

/// A mesh whose triangles are compared.
pub(super) struct Triangles<'a> {
    vertices_m: &'a [Point3<f64>],
    triangles: &'a [[u32; 3]],
    /// Perpendicular to each triangle, twice as long as its area.
    normals: Vec<Vector3<f64>>,
    /// Vertices whose triangles are known not to intersect each other; none where nothing is known.
    plain: Vec<bool>,
    /// Bounds of the rounding error of a length along a unit vector, and of the volume that three edges span (a triple
    /// product). The sign of a smaller result may be wrong and is decided exactly.
    doubt_m: f64,
    doubt_m3: f64,
}

impl<'a> Triangles<'a> {
    pub fn new(vertices_m: &'a [Point3<f64>], triangles: &'a [[u32; 3]]) -> Self {
        let mut longest_sq = 0.0;
        let normal = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|index| vertices_m[index as usize]);
            let (ab, ac) = (b - a, c - a);
            longest_sq = ab.norm_squared().max(ac.norm_squared()).max(longest_sq);
            ab.cross(&ac)
        };
        let normals = triangles.iter().map(normal).collect();
        Self {
            vertices_m,
            triangles,
            normals,
            plain: Vec::new(),
            // 1e-14 is 45 units of rounding of f64 (2.2e-16): more than the few operations of either can accumulate.
            doubt_m: 1e-14 * longest_sq.sqrt(),
            doubt_m3: 1e-14 * longest_sq * longest_sq.sqrt(),
        }
    }

    /// Lets [`Self::intersect`] skip most pairs that share a vertex; nearly all pairs whose boxes touch share one.
    pub fn skip_plain_fans(&mut self, fans: &Fans) {
        self.plain = fans.are_plain(self.vertices_m, &self.normals);
    }

    /// Whether two triangles whose boxes touch have a point in common beyond the vertices that they share.
    ///
    /// Exact for the given coordinates. Triangles in one plane intersect where their interiors overlap. A triangle listed
    /// twice does not intersect its copy.
    pub fn intersect(&self, first: u32, second: u32) -> bool {
        let pair = [first, second];
        let [one, other] = pair.map(|index| &self.triangles[index as usize]);
        match shared(one, other) {
            Shared::None => self.disjoint(pair),
            Shared::Vertex(i, _) if self.plain.get(one[i] as usize) == Some(&true) => false,
            Shared::Vertex(i, j) => self.at_a_vertex(pair, [rotated(one, i), rotated(other, j)]),
            Shared::Edge(apex) => self.at_an_edge(pair, other[apex]),
            Shared::All => false,
        }
    }

    fn disjoint(&self, [first, second]: [u32; 2]) -> bool {
        let corners = |index: u32| self.triangles[index as usize];
        let sides = corners(second).map(|corner| self.side(first, corner));
        if is_apart(&sides) {
            return false;
        }
        let sides_of_first = corners(first).map(|corner| self.side(second, corner));
        if is_apart(&sides_of_first) {
            return false;
        }
        let [first, second] = [first, second].map(|index| self.places(&corners(index)));
        if sides == [0.0; 3] {
            return overlap_in_plane(&first, &second);
        }
        edges_cross(&first, &sides_of_first, &second) || edges_cross(&second, &sides, &first)
    }

    /// The triangles, their corners given, share their first corner. They meet elsewhere only where the edge opposite to it
    /// of one crosses the other.
    fn at_a_vertex(&self, [first, second]: [u32; 2], corners: [[u32; 3]; 2]) -> bool {
        if self.lie_apart(&corners) {
            return false;
        }
        let sides = [1, 2].map(|k| self.side(first, corners[1][k]));
        if is_apart(&sides) {
            return false;
        }
        let sides_of_first = [1, 2].map(|k| self.side(second, corners[0][k]));
        if is_apart(&sides_of_first) {
            return false;
        }
        let [first, second] = corners.map(|corners| self.places(&corners));
        if sides == [0.0; 2] {
            return overlap_in_plane(&first, &second);
        }
        let crosses = |from: &Triangle, sides: [f64; 2], triangle: &Triangle| {
            sides != [0.0; 2] && segment_hits(&from[1], &from[2], triangle)
        };
        crosses(&second, sides, &first) || crosses(&first, sides_of_first, &second)
    }

    /// Quick rejection for triangles that share their first corner: whether the plane through it, halfway between the two
    /// triangles' directions, clearly separates them. True for most pairs without a common edge.
    fn lie_apart(&self, corners: &[[u32; 3]; 2]) -> bool {
        let [first, second] = corners.map(|corners| {
            let [apex, b, c] = self.places(&corners);
            [b - apex, c - apex]
        });
        let middle = |edges: &[Vector3<f64>; 2]| (edges[0] + edges[1]).normalize();
        let across = middle(&first) - middle(&second);
        first.iter().all(|edge| edge.dot(&across) > self.doubt_m)
            && second.iter().all(|edge| edge.dot(&across) < -self.doubt_m)
    }

    /// The triangles share all but the second's corner `apex`: they meet elsewhere only where one is folded flat onto the
    /// other.
    fn at_an_edge(&self, [first, second]: [u32; 2], apex: u32) -> bool {
        let [turned, corners] = [first, second].map(|index| self.triangles[index as usize]);
        self.side(first, apex) == 0.0
            && overlap_in_plane(&self.places(&turned), &self.places(&corners))
    }

    /// On which side of a triangle's plane a vertex lies: positive, negative, or zero for on it. The sign is exact.
    fn side(&self, triangle: u32, vertex: u32) -> f64 {
        let corners = self.triangles[triangle as usize];
        let from = self.vertices_m[corners[0] as usize];
        let point = self.vertices_m[vertex as usize];
        let volume_m3 = self.normals[triangle as usize].dot(&(from - point));
        if volume_m3.abs() > self.doubt_m3 {
            return volume_m3;
        }
        let [a, b, c] = self.places(&corners);
        turn(&a, &b, &c, &point)
    }

    fn places(&self, triangle: &[u32; 3]) -> Triangle {
        triangle.map(|index| self.vertices_m[index as usize])
    }
}

enum Shared {
    None,
    /// Position of the vertex in either triangle.
    Vertex(usize, usize),
    /// Position of the second triangle's vertex that is not shared.
    Edge(usize),
    All,
}

fn shared(first: &[u32; 3], second: &[u32; 3]) -> Shared {
    let mut count = 0;
    let mut at = (0, 0);
    for (i, a) in first.iter().enumerate() {
        for (j, b) in second.iter().enumerate() {
            if a == b {
                count += 1;
                at = (i, j);
            }
        }
    }
    match count {
        0 => Shared::None,
        1 => Shared::Vertex(at.0, at.1),
        2 => Shared::Edge((0..3).find(|&j| !first.contains(&second[j])).unwrap_or(0)),
        _ => Shared::All,
    }
}

fn rotated(triangle: &[u32; 3], first: usize) -> [u32; 3] {
    [0, 1, 2].map(|k| triangle[(first + k) % 3])
}

type Triangle = [Point3<f64>; 3];

fn is_apart(sides: &[f64]) -> bool {
    sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
}

/// Whether an edge of `from`, whose corners lie on `sides` of the other triangle's plane, meets that triangle.
fn edges_cross(from: &Triangle, sides: &[f64; 3], triangle: &Triangle) -> bool {
    (0..3).any(|k| {
        let next = (k + 1) % 3;
        let is_in_plane = sides[k] == 0.0 && sides[next] == 0.0;
        let is_aside = sides[k] > 0.0 && sides[next] > 0.0 || sides[k] < 0.0 && sides[next] < 0.0;
        !is_in_plane && !is_aside && segment_hits(&from[k], &from[next], triangle)
    })
}

/// Whether the line through a segment that reaches the triangle's plane meets the triangle.
fn segment_hits(start: &Point3<f64>, end: &Point3<f64>, triangle: &Triangle) -> bool {
    let [a, b, c] = triangle;
    let turns = [[a, b], [b, c], [c, a]].map(|[from, to]| turn(start, end, from, to));
    turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0)
}

/// Volume of a tetrahedron with an exact sign (Shewchuk's adaptive orient3d).
fn turn(a: &Point3<f64>, b: &Point3<f64>, c: &Point3<f64>, d: &Point3<f64>) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    orient3d(a, b, c, d)
}

/// Whether the interiors of two triangles in one plane overlap: no edge of either has the other on its outer side.
fn overlap_in_plane(first: &Triangle, second: &Triangle) -> bool {
    let normal = mesh::triangle::area_normal(*first);
    let drop = normal.iamax();
    let flat = |point: &Point3<f64>| [point[(drop + 1) % 3], point[(drop + 2) % 3]];
    let [first, second] = [first, second].map(|triangle| triangle.each_ref().map(flat));
    !separates(&first, &second) && !separates(&second, &first)
}

fn separates(triangle: &[[f64; 2]; 3], other: &[[f64; 2]; 3]) -> bool {
    (0..3).any(|k| {
        let [from, to, inside] = [0, 1, 2].map(|step| triangle[(k + step) % 3]);
        let inner = turn_2d(from, to, inside).signum();
        other
            .iter()
            .all(|&point| turn_2d(from, to, point) * inner <= 0.0)
    })
}

fn turn_2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| robust::Coord { x: p[0], y: p[1] });
    robust::orient2d(a, b, c)
}
