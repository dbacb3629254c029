//! Marching cubes: the isosurface f = iso as triangles.

use nalgebra::Point3;

use super::lattice::{self, STEPS};
use super::level::Level;

/// Points and triangles, in double precision.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surface {
    pub points: Vec<Point3<f64>>,
    /// Counter-clockwise seen from where f is larger.
    pub triangles: Vec<[u32; 3]>,
}

/// An edge of a cell: its lower corner (bits x, y, z from the highest) and its axis.
type Edge = (usize, usize);

/// The surface f = `iso` in the cells of a level, in the unit cube.
pub(super) fn contour(level: &Level, iso: f64) -> Surface {
    let cases: Vec<Vec<[Edge; 3]>> = (0..256).map(triangles).collect();
    let mut surface = Surface::default();
    // Index of the point on each edge of the lattice, by its lower place and axis.
    let mut points = vec![u32::MAX; 3 * level.values.len()];
    for &cell in &level.cells {
        let Some(values) = level.cell_values(cell) else {
            continue;
        };
        let case = (0..8)
            .filter(|&corner| values[corner] < iso)
            .fold(0, |case, corner| case | 1 << corner);
        for triangle in &cases[case] {
            surface.triangles.push(triangle.map(|edge| {
                let (place, position) = point_on(level, cell, edge, &values, iso);
                let index = &mut points[3 * place + edge.1];
                if *index == u32::MAX {
                    *index = surface.points.len() as u32;
                    surface.points.push(position);
                }
                *index
            }));
        }
    }
    surface
}

/// The lattice place at the lower end of a cell's edge, and where f = `iso` on the edge.
fn point_on(
    level: &Level,
    cell: u64,
    edge: Edge,
    values: &[f64; 8],
    iso: f64,
) -> (usize, Point3<f64>) {
    let (corner, axis) = edge;
    let key = cell
        + (corner as u64 >> 2) * STEPS[0]
        + (corner as u64 >> 1 & 1) * STEPS[1]
        + (corner as u64 & 1) * STEPS[2];
    let (low, high) = (values[corner], values[corner | 4 >> axis]);
    let mut place = lattice::place(key).map(f64::from);
    place[axis] += (iso - low) / (high - low);
    let index = level.lattice.find(key).unwrap_or_default() as usize;
    (
        index,
        Point3::from(place.map(|coordinate| coordinate * level.cell())),
    )
}

/// The triangles of a cell; `inside` has one bit for each corner at which f is below iso.
fn triangles(inside: usize) -> Vec<[Edge; 3]> {
    let mut triangles = Vec::new();
    for polygon in polygons(inside) {
        let len = polygon.len();
        // The neighbouring cell might use the same diagonal of a common face, which would then have four triangles.
        let in_faces = |&apex: &usize| {
            let others = (2..len - 1).map(|step| polygon[(apex + step) % len]);
            others
                .filter(|&edge| share_a_face(polygon[apex], edge))
                .count()
        };
        let apex = (0..len).min_by_key(in_faces).unwrap_or(0);
        let at = |step: usize| polygon[(apex + step) % len];
        triangles.extend((1..len - 1).map(|step| [at(0), at(step), at(step + 1)]));
    }
    triangles
}

fn share_a_face(a: Edge, b: Edge) -> bool {
    let side = |(corner, axis): Edge, of: usize| (axis != of).then_some(corner & (4 >> of));
    (0..3).any(|axis| side(a, axis).is_some() && side(a, axis) == side(b, axis))
}

/// Polygons of the surface in a cell. In each face of the cell a segment separates every run of inside corners from the
/// others, by the same rule in both cells that share the face; so the surface has no cracks.
fn polygons(inside: usize) -> Vec<Vec<Edge>> {
    let is_inside = |corner: usize| inside >> corner & 1 == 1;
    let mut lines: Vec<(Edge, Edge)> = Vec::new();
    for face in faces() {
        let crossing = |at: usize| edge_between(face[at % 4], face[(at + 1) % 4]);
        let changes = |at: usize| is_inside(face[at % 4]) != is_inside(face[(at + 1) % 4]);
        for start in (0..4).filter(|&at| changes(at) && is_inside(face[(at + 1) % 4])) {
            if let Some(end) = (start + 1..start + 4).find(|&at| changes(at)) {
                lines.push((crossing(start), crossing(end)));
            }
        }
    }
    let mut polygons = Vec::new();
    while let Some((first, mut end)) = lines.pop() {
        let mut polygon = vec![first];
        while end != first {
            polygon.push(end);
            match lines.iter().position(|line| line.0 == end) {
                Some(next) => end = lines.swap_remove(next).1,
                None => break,
            }
        }
        polygons.push(polygon);
    }
    polygons
}

fn edge_between(a: usize, b: usize) -> Edge {
    let axis = match a ^ b {
        4 => 0,
        2 => 1,
        _ => 2,
    };
    (a & b, axis)
}

/// Corners of each face of a cell, counter-clockwise seen from outside.
fn faces() -> [[usize; 4]; 6] {
    [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ]
}
