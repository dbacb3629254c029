//! The laws that a mesh must keep to be deformed.

use mesh::Mesh;
use nalgebra::Point3;

use crate::edges::{Edges, sides};

/// Least height of a triangle, as a share of its longest edge. Flatter ones count as having no area.
pub const HEIGHT_MIN: f64 = 1e-6;

/// A law that a mesh breaks, at the first place where it does.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Defect {
    /// There is nothing.
    #[error("the mesh has no triangles")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Its index.
        vertex: u32,
    },
    /// A triangle names a vertex that is not there, or one twice.
    #[error("triangle {triangle} names vertices {corners:?}")]
    Corners {
        /// Its index.
        triangle: usize,
        /// Its corners.
        corners: [u32; 3],
    },
    /// A triangle has no area.
    #[error("triangle {triangle} has no area")]
    Flat {
        /// Its index.
        triangle: usize,
    },
    /// An edge has more than two triangles, or two that run along it in the same direction.
    #[error("the edge from vertex {from} to {to} has two triangles on one side")]
    Edge {
        /// Where the edge starts.
        from: u32,
        /// Where it ends.
        to: u32,
    },
    /// The triangles at a vertex are not one fan.
    #[error("the triangles at vertex {vertex} form more than one fan")]
    Fans {
        /// Its index.
        vertex: u32,
    },
    /// A vertex has no triangle.
    #[error("vertex {vertex} has no triangle")]
    Unused {
        /// Its index.
        vertex: u32,
    },
    /// The mesh falls into parts.
    #[error("the mesh has {0} parts")]
    Parts(usize),
}

/// Whether a mesh can be deformed: every edge has one or two triangles, which run along it in opposite directions; the
/// triangles at every vertex form one fan; there is one component, no triangle without area and no vertex without one.
///
/// # Errors
/// The first [`Defect`] that is found.
pub fn check(mesh: &Mesh) -> Result<(), Defect> {
    if mesh.triangles.is_empty() {
        return Err(Defect::Empty);
    }
    let is_bad = |vertex: &Point3<f32>| !cloud::is_finite(vertex);
    if let Some(vertex) = mesh.vertices.iter().position(is_bad) {
        return Err(Defect::NotFinite {
            vertex: vertex as u32,
        });
    }
    for (triangle, &corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = corners;
        let is_there = corners
            .iter()
            .all(|&corner| (corner as usize) < mesh.vertices.len());
        if a == b || b == c || c == a || !is_there {
            return Err(Defect::Corners { triangle, corners });
        }
        if is_flat(&mesh.vertices, corners) {
            return Err(Defect::Flat { triangle });
        }
    }
    let edges = Edges::of(mesh);
    check_edges(mesh, &edges)?;
    check_fans(mesh, &edges)?;
    match components(mesh.vertices.len(), &mesh.triangles).1 {
        1 => Ok(()),
        count => Err(Defect::Parts(count)),
    }
}

/// Whether a triangle has no area worth the name.
pub(crate) fn is_flat(vertices: &[Point3<f32>], corners: [u32; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| vertices[corner as usize].cast::<f64>());
    let longest_sq = (b - a)
        .norm_squared()
        .max((c - b).norm_squared())
        .max((a - c).norm_squared());
    // Twice the area is the longest edge times its height.
    (b - a).cross(&(c - a)).norm() <= HEIGHT_MIN * longest_sq
}

fn check_edges(mesh: &Mesh, edges: &Edges) -> Result<(), Defect> {
    for &corners in &mesh.triangles {
        for (from, to) in sides(corners) {
            if edges.triangles(from, to).nth(1).is_some() {
                return Err(Defect::Edge { from, to });
            }
        }
    }
    Ok(())
}

/// A fan is a path of triangles, each sharing an edge with the next; a closed one has no first.
fn check_fans(mesh: &Mesh, edges: &Edges) -> Result<(), Defect> {
    for vertex in 0..mesh.vertices.len() as u32 {
        let from = edges.from(vertex);
        let Some(&(any, _)) = from.first() else {
            return Err(Defect::Unused { vertex });
        };
        // A fan starts where no triangle comes before its first edge; any edge starts a closed one.
        let mut starts = from
            .iter()
            .map(|&(to, _)| to)
            .filter(|&to| !edges.contains(to, vertex));
        let first = starts.next().unwrap_or(any);
        let mut seen = 0;
        let mut next = Some(first);
        while let Some(triangle) = next.and_then(|to| edges.triangles(vertex, to).next()) {
            seen += 1;
            // The edge that leads back to the vertex.
            let back = sides(mesh.triangles[triangle as usize])
                .into_iter()
                .find(|(_, to)| *to == vertex);
            next = back.map(|(from, _)| from);
            if next == Some(first) || seen > from.len() {
                break;
            }
        }
        if seen != from.len() {
            return Err(Defect::Fans { vertex });
        }
    }
    Ok(())
}

/// The component of each vertex, numbered in order of their first triangles, and how many there are.
pub(crate) fn components(vertex_count: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut parents: Vec<u32> = (0..vertex_count as u32).collect();
    fn root(parents: &mut [u32], mut at: u32) -> u32 {
        while parents[at as usize] != at {
            let above = parents[parents[at as usize] as usize];
            parents[at as usize] = above;
            at = above;
        }
        at
    }
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (a, other) = (root(&mut parents, a), root(&mut parents, other));
            parents[a.max(other) as usize] = a.min(other);
        }
    }
    let mut numbers = vec![u32::MAX; vertex_count];
    let mut count = 0;
    for corner in triangles.iter().flatten() {
        let root = root(&mut parents, *corner) as usize;
        if numbers[root] == u32::MAX {
            numbers[root] = count;
            count += 1;
        }
        numbers[*corner as usize] = numbers[root];
    }
    (numbers, count as usize)
}
