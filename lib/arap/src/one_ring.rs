//! One-rings: the neighbours of each vertex, and the cotangent weight of the edge to each.

use mesh::{Mesh, Rows, Spoke, triangle};
use nalgebra::Point3;

/// Why a mesh has no sound one-rings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// No triangles.
    #[error(
        "a mesh of {vertices} vertices and {triangles} triangles; it needs at least one triangle"
    )]
    Empty {
        /// How many vertices it has.
        vertices: usize,
        /// How many triangles it has.
        triangles: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("vertex {vertex} at {place} is not finite; drop it and its triangles first")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Its position.
        place: Point3<f32>,
    },
    /// An index beyond the vertices.
    #[error(
        "triangle {triangle} names vertex {vertex}, but there are {vertices}; indices start at 0"
    )]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// The index it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A triangle that is an edge or a point.
    #[error("triangle {triangle} names vertex {vertex} twice; drop such triangles first")]
    RepeatedCorner {
        /// Index of the triangle.
        triangle: usize,
        /// The vertex it names twice.
        vertex: u32,
    },
    /// Vertices that nothing ties to the rest.
    #[error("{count} vertices are in no triangle, vertex {first} the first; drop them first")]
    Isolated {
        /// The first of them.
        first: usize,
        /// How many there are.
        count: usize,
    },
}

/// The neighbours of each vertex, ascending, and the weight of the edge to each.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OneRings(Rows<(u32, f64)>);

/// Weight of an edge whose mean cotangent is negative: too small to show in an energy, but enough to tie a vertex with
/// only such edges to its neighbours.
const WEIGHT_MIN: f64 = 1e-9;

impl OneRings {
    /// One-rings of a mesh. The weight of an edge is the mean cotangent of the angles opposite to it (paper Eq. 2): two
    /// of them inside a surface, one on a boundary, more where the mesh is not manifold.
    pub fn new(mesh: &Mesh) -> Result<Self, MeshFault> {
        check(mesh)?;
        let half_edges = mesh.half_edges();
        let mut rings = Rows::new();
        for vertex in 0..half_edges.vertex_count() as u32 {
            let cotangent =
                |spoke: &Spoke| triangle::cotangent(mesh.corners(&[spoke.apex, vertex, spoke.to]));
            let spokes = half_edges.spokes(vertex);
            let edges = spokes.chunk_by(|a, b| a.to == b.to);
            rings.push(edges.map(|edge| {
                let mean = edge.iter().map(cotangent).sum::<f64>() / edge.len() as f64;
                (edge[0].to, mean.max(WEIGHT_MIN))
            }));
        }
        let isolated = || (0..rings.len()).filter(|&vertex| rings.of(vertex).is_empty());
        match isolated().next() {
            Some(first) => Err(MeshFault::Isolated {
                first,
                count: isolated().count(),
            }),
            None => Ok(Self(rings)),
        }
    }

    /// The pattern of a symmetric matrix: for each row the entries off the diagonal, which take the place of weights.
    pub fn of_entries(
        rows: impl IntoIterator<Item = impl IntoIterator<Item = (u32, f64)>>,
    ) -> Self {
        Self(rows.into_iter().collect())
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Neighbours of a vertex, each with the weight of the edge to it.
    #[inline]
    pub fn of(&self, vertex: usize) -> impl ExactSizeIterator<Item = (usize, f64)> {
        let ring = self.0.of(vertex).iter();
        ring.map(|&(neighbour, weight)| (neighbour as usize, weight))
    }

    /// The same rings with vertex `order[k]` named k.
    pub fn renamed(&self, order: &[usize]) -> Self {
        let mut names = vec![0; order.len()];
        for (name, &vertex) in order.iter().enumerate() {
            names[vertex] = name as u32;
        }
        let ring = |&vertex: &usize| {
            let ring = self.of(vertex).map(|(to, weight)| (names[to], weight));
            let mut ring: Vec<_> = ring.collect();
            ring.sort_by_key(|&(to, _)| to);
            ring
        };
        Self(order.iter().map(ring).collect())
    }
}

fn check(mesh: &Mesh) -> Result<(), MeshFault> {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    if vertices == 0 || triangles == 0 {
        return Err(MeshFault::Empty {
            vertices,
            triangles,
        });
    }
    let finite = |place: &Point3<f32>| place.iter().all(|coordinate| coordinate.is_finite());
    if let Some(vertex) = mesh.vertices.iter().position(|place| !finite(place)) {
        let place = mesh.vertices[vertex];
        return Err(MeshFault::NotFinite { vertex, place });
    }
    for (triangle, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if let Some(vertex) = [a, b, c]
            .into_iter()
            .find(|&vertex| vertex as usize >= vertices)
        {
            return Err(MeshFault::NoSuchVertex {
                triangle,
                vertex,
                vertices,
            });
        }
        if a == b || b == c || c == a {
            let vertex = if b == c { b } else { a };
            return Err(MeshFault::RepeatedCorner { triangle, vertex });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
