//! Whether two triangles of a mesh pass through each other.

use nalgebra::Point3;
use robust::{Coord3D, orient3d};

/// Whether two triangles have a point in common beyond the vertices that they share.
///
/// Exact for the given coordinates. Triangles in one plane intersect where their interiors overlap. A triangle listed twice
/// does not intersect its copy.
pub(super) fn intersect(vertices_m: &[Point3<f64>], first: &[u32; 3], second: &[u32; 3]) -> bool {
    let place = |index: u32| vertices_m[index as usize];
    match shared(first, second) {
        Shared::None => disjoint(&first.map(place), &second.map(place)),
        Shared::Vertex(i, j) => at_a_vertex(
            &rotated(first, i).map(place),
            &rotated(second, j).map(place),
        ),
        Shared::Edge(apex) => at_an_edge(&first.map(place), &rotated(second, apex).map(place)),
        Shared::All => false,
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

fn disjoint(first: &Triangle, second: &Triangle) -> bool {
    let sides = second.map(|point| side(first, &point));
    if is_apart(&sides) {
        return false;
    }
    let sides_of_first = first.map(|point| side(second, &point));
    if is_apart(&sides_of_first) {
        return false;
    }
    if sides == [0.0; 3] {
        return overlap_in_plane(first, second);
    }
    edges_cross(first, &sides_of_first, second) || edges_cross(second, &sides, first)
}

/// The triangles share their first vertex. They meet elsewhere only where the edge opposite to it of one crosses the other.
fn at_a_vertex(first: &Triangle, second: &Triangle) -> bool {
    let sides = [side(first, &second[1]), side(first, &second[2])];
    if is_apart(&sides) {
        return false;
    }
    let sides_of_first = [side(second, &first[1]), side(second, &first[2])];
    if is_apart(&sides_of_first) {
        return false;
    }
    if sides == [0.0; 2] {
        return overlap_in_plane(first, second);
    }
    let [crosses_first, crosses_second] =
        [(second, &sides, first), (first, &sides_of_first, second)].map(
            |(from, sides, triangle)| {
                *sides != [0.0; 2] && segment_hits(&from[1], &from[2], triangle)
            },
        );
    crosses_first || crosses_second
}

/// The triangles share all but the second's first vertex: they meet elsewhere only where one is folded flat onto the other.
fn at_an_edge(first: &Triangle, second: &Triangle) -> bool {
    side(first, &second[0]) == 0.0 && overlap_in_plane(first, second)
}

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

fn side(triangle: &Triangle, point: &Point3<f64>) -> f64 {
    turn(&triangle[0], &triangle[1], &triangle[2], point)
}

/// Sign of the volume of a tetrahedron, exactly.
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
    let normal = (first[1] - first[0]).cross(&(first[2] - first[0]));
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
