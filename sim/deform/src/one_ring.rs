//! Who is next to whom on a mesh, and how much each edge weighs.

use mesh::Mesh;
use nalgebra::{Point3, Vector3};

/// Why a mesh has no sound one-rings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// Nothing to work on.
    #[error(
        "a mesh of {vertices} vertices and {triangles} triangles; it needs at least one triangle"
    )]
    Empty {
        /// How many vertices it has.
        vertices: usize,
        /// How many triangles it has.
        triangles: usize,
    },
    /// A place that is no number.
    #[error("vertex {vertex} at {place} is not finite; drop it and its triangles first")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Where it is.
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
pub(crate) struct OneRings {
    /// Where each vertex's neighbours start; one more than there are vertices.
    starts: Vec<usize>,
    neighbours: Vec<u32>,
    weights: Vec<f64>,
}

/// An angle's cotangent is cut off here, so that a triangle of no area weighs much, but not infinitely much.
const COTANGENT_MAX: f64 = 1e4;
/// An edge whose mean cotangent is negative weighs this: nothing that shows in an energy, but enough to tie a vertex,
/// all of whose edges are such, to its neighbours.
const WEIGHT_MIN: f64 = 1e-9;

impl OneRings {
    /// Edges of the triangles. An edge weighs the mean of the cotangents of the angles opposite to it (paper Eq. 2):
    /// two of them inside a surface, one at its rim, more where it is not a manifold.
    pub fn new(mesh: &Mesh) -> Result<Self, MeshFault> {
        check(mesh)?;
        let mut half_edges = half_edges(mesh);
        half_edges.sort_by_key(|&(from, to, _)| (from, to));
        let mut rings = Self {
            starts: vec![0; mesh.vertices.len() + 1],
            neighbours: Vec::new(),
            weights: Vec::new(),
        };
        for edge in half_edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let sum: f64 = edge.iter().map(|&(_, _, cotangent)| cotangent).sum();
            rings.starts[edge[0].0 as usize + 1] += 1;
            rings.neighbours.push(edge[0].1);
            rings
                .weights
                .push((sum / edge.len() as f64).max(WEIGHT_MIN));
        }
        let isolated = || (1..rings.starts.len()).filter(|&end| rings.starts[end] == 0);
        if let Some(first) = isolated().next() {
            let count = isolated().count();
            return Err(MeshFault::Isolated {
                first: first - 1,
                count,
            });
        }
        for vertex in 0..mesh.vertices.len() {
            rings.starts[vertex + 1] += rings.starts[vertex];
        }
        Ok(rings)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a vertex, each with the weight of the edge to it.
    #[inline]
    pub fn of(&self, vertex: usize) -> impl ExactSizeIterator<Item = (usize, f64)> {
        let ring = self.starts[vertex]..self.starts[vertex + 1];
        self.neighbours[ring.clone()]
            .iter()
            .map(|&neighbour| neighbour as usize)
            .zip(self.weights[ring].iter().copied())
    }

    /// The same rings with vertex `order[k]` named k.
    pub fn renamed(&self, order: &[usize]) -> Self {
        let mut names = vec![0; order.len()];
        for (name, &vertex) in order.iter().enumerate() {
            names[vertex] = name as u32;
        }
        let mut renamed = Self {
            starts: vec![0],
            neighbours: Vec::with_capacity(self.neighbours.len()),
            weights: Vec::with_capacity(self.weights.len()),
        };
        for &vertex in order {
            let mut ring: Vec<_> = self
                .of(vertex)
                .map(|(to, weight)| (names[to], weight))
                .collect();
            ring.sort_by_key(|&(to, _)| to);
            renamed.neighbours.extend(ring.iter().map(|&(to, _)| to));
            renamed
                .weights
                .extend(ring.iter().map(|&(_, weight)| weight));
            renamed.starts.push(renamed.neighbours.len());
        }
        renamed
    }

    /// For each vertex the number of the connected component it belongs to; they are numbered from 0.
    pub fn components(&self) -> Vec<u32> {
        let mut components = vec![u32::MAX; self.len()];
        let mut count = 0;
        let mut reached = Vec::new();
        for seed in 0..self.len() {
            if components[seed] != u32::MAX {
                continue;
            }
            components[seed] = count;
            reached.push(seed);
            while let Some(vertex) = reached.pop() {
                for (neighbour, _) in self.of(vertex) {
                    if components[neighbour] == u32::MAX {
                        components[neighbour] = count;
                        reached.push(neighbour);
                    }
                }
            }
            count += 1;
        }
        components
    }
}

/// Surface area of a mesh, in square metres.
pub(crate) fn area_m2(mesh: &Mesh) -> f64 {
    let doubled: f64 = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = corners(mesh, triangle);
            (b - a).cross(&(c - a)).norm()
        })
        .sum();
    doubled / 2.0
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

/// Each triangle's edges in both directions, with the cotangent of the angle opposite.
fn half_edges(mesh: &Mesh) -> Vec<(u32, u32, f64)> {
    let mut edges = Vec::with_capacity(6 * mesh.triangles.len());
    for triangle in &mesh.triangles {
        let places = corners(mesh, triangle);
        for apex in 0..3 {
            let (from, to) = ((apex + 1) % 3, (apex + 2) % 3);
            let cotangent = cotangent(places[from] - places[apex], places[to] - places[apex]);
            edges.push((triangle[from], triangle[to], cotangent));
            edges.push((triangle[to], triangle[from], cotangent));
        }
    }
    edges
}

fn corners(mesh: &Mesh, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
    triangle.map(|vertex| mesh.vertices[vertex as usize].coords.cast())
}

/// Cotangent of the angle between two sides; 0 where a side has no length.
fn cotangent(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    let (along, across) = (a.dot(&b), a.cross(&b).norm());
    if along.abs() < COTANGENT_MAX * across {
        along / across
    } else if along == 0.0 {
        0.0
    } else {
        COTANGENT_MAX.copysign(along)
    }
}

#[cfg(test)]
mod tests;
