//! The conditions that a mesh must meet to be deformed.

use mesh::{HalfEdges, Mesh, sides, triangle};
use nalgebra::Point3;

/// Least height of a triangle, as a share of its longest edge. Flatter ones count as degenerate: a vertex's f32 rounding
/// (6e-8 of its coordinate) could turn their normals.
pub const HEIGHT_MIN: f64 = 1e-6;

/// A condition that a mesh violates, with the first vertex, edge or triangle that does.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Defect {
    /// No triangles.
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
    /// A vertex belongs to no triangle.
    #[error("vertex {vertex} has no triangle")]
    Unused {
        /// Its index.
        vertex: u32,
    },
    /// The mesh has several connected components.
    #[error("the mesh has {0} parts")]
    Parts(usize),
}

/// Checks that a mesh can be deformed: it is an oriented manifold, possibly with boundary (every edge has one or two
/// triangles, which run along it in opposite directions; the triangles at every vertex form one fan), with one connected
/// component, no degenerate triangle and no unused vertex.
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
    let edges = mesh.half_edges();
    check_edges(mesh, &edges)?;
    check_fans(&edges)?;
    match mesh::components(mesh.vertices.len(), &mesh.triangles).1 {
        1 => Ok(()),
        count => Err(Defect::Parts(count)),
    }
}

/// Whether a triangle is degenerate: flatter than [`HEIGHT_MIN`].
pub(crate) fn is_flat(vertices: &[Point3<f32>], corners: [u32; 3]) -> bool {
    let places = corners.map(|corner| vertices[corner as usize].cast::<f64>());
    let [a, b, c] = places;
    let longest_sq = (b - a)
        .norm_squared()
        .max((c - b).norm_squared())
        .max((a - c).norm_squared());
    // Twice the area is the longest edge times its height.
    triangle::area_normal(places).norm() <= HEIGHT_MIN * longest_sq
}

fn check_edges(mesh: &Mesh, edges: &HalfEdges) -> Result<(), Defect> {
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
fn check_fans(edges: &HalfEdges) -> Result<(), Defect> {
    for vertex in 0..edges.vertex_count() as u32 {
        let from = edges.from(vertex);
        let Some(any) = from.first() else {
            return Err(Defect::Unused { vertex });
        };
        // An open fan starts at the edge that no triangle precedes; a closed one can start anywhere.
        let mut starts = from
            .iter()
            .map(|edge| edge.end)
            .filter(|&to| !edges.contains(to, vertex));
        let first = starts.next().unwrap_or(any.end);
        let mut seen = 0;
        let mut next = first;
        while let Some(edge) = from.iter().find(|edge| edge.end == next) {
            seen += 1;
            // From there an edge leads back to the vertex.
            next = edge.apex;
            if next == first || seen > from.len() {
                break;
            }
        }
        if seen != from.len() {
            return Err(Defect::Fans { vertex });
        }
    }
    Ok(())
}
