//! Adjacency of triangles and vertices by half-edges.

use std::collections::BTreeMap;

use crate::rows::Rows;

/// The directed edges of a triangle, in its order.
pub fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// A half-edge: one directed side of a triangle, stored at the vertex where it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HalfEdge {
    /// The vertex at which it ends.
    pub end: u32,
    /// The triangle's third vertex, where the previous half-edge of the triangle starts.
    pub apex: u32,
    /// Index of the triangle.
    pub triangle: u32,
}

/// An edge at a vertex regardless of direction; there is one for each triangle of the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Spoke {
    /// The vertex at the other end.
    pub to: u32,
    /// Index of the triangle.
    pub triangle: u32,
    /// The triangle's third vertex.
    pub apex: u32,
}

/// An undirected edge with its triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edge {
    /// Its vertices, ascending.
    pub ends: [u32; 2],
    /// Its triangles, ascending: two inside a surface, one at its boundary, more where it is not a manifold.
    pub triangles: Vec<u32>,
}

/// The half-edges that start at each vertex, by ascending triangle: one for each triangle at the vertex.
#[derive(Debug, Clone)]
pub struct HalfEdges {
    at: Rows<HalfEdge>,
}

impl HalfEdges {
    /// Sorts the sides of all triangles by the vertex at which they start.
    ///
    /// # Panics
    /// If a triangle names a vertex that does not exist.
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut sides = Vec::with_capacity(3 * triangles.len());
        for (triangle, &[a, b, c]) in (0..).zip(triangles) {
            for (from, end, apex) in [(a, b, c), (b, c, a), (c, a, b)] {
                let half_edge = HalfEdge {
                    end,
                    apex,
                    triangle,
                };
                assert!((from as usize) < vertex_count, "vertex {from} is missing");
                sides.push((from, half_edge));
            }
        }
        sides.sort_by_key(|&(from, _)| from);
        let mut rest = &sides[..];
        let row = |vertex| {
            let (row, after) = rest.split_at(rest.partition_point(|&(from, _)| from == vertex));
            rest = after;
            row.iter().map(|&(_, half_edge)| half_edge)
        };
        Self {
            at: (0..vertex_count as u32).map(row).collect(),
        }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.at.len()
    }

    /// The half-edges that start at a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn from(&self, vertex: u32) -> &[HalfEdge] {
        self.at.of(vertex as usize)
    }

    /// The triangles that run along an edge in this direction, ascending.
    pub fn triangles(&self, from: u32, to: u32) -> impl Iterator<Item = u32> {
        let there = self.from(from).iter().filter(move |edge| edge.end == to);
        there.map(|edge| edge.triangle)
    }

    /// Whether any triangle runs along an edge in this direction.
    pub fn contains(&self, from: u32, to: u32) -> bool {
        self.triangles(from, to).next().is_some()
    }

    /// The edges at a vertex, sorted by their other end, then by triangle. A neighbour occurs once for each triangle of the
    /// edge.
    pub fn spokes(&self, vertex: u32) -> Vec<Spoke> {
        let both = |edge: &HalfEdge| {
            [(edge.end, edge.apex), (edge.apex, edge.end)].map(|(to, apex)| Spoke {
                to,
                triangle: edge.triangle,
                apex,
            })
        };
        let mut spokes: Vec<Spoke> = self.from(vertex).iter().flat_map(both).collect();
        spokes.sort_unstable();
        spokes
    }

    /// The one-ring of each vertex: its neighbours, each once, ascending.
    pub fn one_rings(&self) -> Rows<u32> {
        let ring = |vertex| {
            let mut ring: Vec<u32> = self.spokes(vertex).iter().map(|spoke| spoke.to).collect();
            ring.dedup();
            ring
        };
        (0..self.vertex_count() as u32).map(ring).collect()
    }

    /// All edges, each once, ascending.
    pub fn edges(&self) -> Vec<Edge> {
        let at = |vertex| {
            let mut spokes = self.spokes(vertex);
            spokes.retain(|spoke| spoke.to > vertex);
            let edges = spokes.chunk_by(|a, b| a.to == b.to).map(|spokes| Edge {
                ends: [vertex, spokes[0].to],
                triangles: spokes.iter().map(|spoke| spoke.triangle).collect(),
            });
            edges.collect::<Vec<_>>()
        };
        (0..self.vertex_count() as u32).flat_map(at).collect()
    }

    /// Boundary loops: closed lines of edges that have a triangle on one side only, as their vertices in the direction in
    /// which these triangles run.
    pub fn boundaries(&self) -> Vec<Vec<u32>> {
        let mut next = BTreeMap::new();
        for vertex in 0..self.vertex_count() as u32 {
            let mut open: Vec<&HalfEdge> = self.from(vertex).iter().collect();
            open.retain(|edge| !self.contains(edge.end, vertex));
            open.sort_by_key(|edge| edge.triangle);
            next.extend(open.iter().map(|edge| (vertex, edge.end)));
        }
        let mut loops = Vec::new();
        while let Some((first, mut at)) = next.pop_first() {
            let mut vertices = vec![first];
            while let Some(to) = next.remove(&at) {
                vertices.push(at);
                at = to;
            }
            loops.push(vertices);
        }
        loops
    }

    /// Number of boundary loops.
    pub fn boundary_loops(&self) -> usize {
        self.boundaries().len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share an edge, and one apart that runs the other way round.
    fn three() -> HalfEdges {
        HalfEdges::new(8, &[[0, 1, 2], [2, 1, 3], [6, 5, 4]])
    }

    #[test]
    fn each_side_starts_at_its_first_vertex() {
        let edges = three();
        assert_eq!(edges.vertex_count(), 8);
        let at_1 = edges.from(1).iter();
        assert_eq!(
            at_1.map(|e| (e.end, e.apex, e.triangle))
                .collect::<Vec<_>>(),
            [(2, 0, 0), (3, 2, 1)]
        );
        assert!(edges.contains(1, 2) && edges.contains(2, 1) && !edges.contains(1, 0));
        assert_eq!(edges.triangles(2, 1).collect::<Vec<_>>(), [1]);
        assert!(edges.from(7).is_empty());
    }

    #[test]
    fn one_rings_and_edges_are_ascending_and_without_repeats() {
        let edges = three();
        let rings = edges.one_rings();
        assert_eq!(rings.of(1), [0, 2, 3]);
        assert_eq!(rings.of(4), [5, 6]);
        assert!(rings.of(7).is_empty());
        let all = edges.edges();
        assert_eq!(all.len(), 8);
        assert!(all.is_sorted_by(|a, b| a.ends < b.ends));
        let inner: Vec<_> = all
            .iter()
            .filter(|edge| edge.triangles.len() == 2)
            .collect();
        assert_eq!(inner.len(), 1);
        assert_eq!(
            (inner[0].ends, &inner[0].triangles[..]),
            ([1, 2], &[0, 1][..])
        );
    }

    #[test]
    fn boundaries_are_counted() {
        assert_eq!(three().boundary_loops(), 2);
        assert_eq!(three().boundaries(), [vec![0, 1, 3, 2], vec![4, 6, 5]]);
        let closed = crate::Mesh::cylinder(1.0, 0.0, 1.0, 5);
        assert_eq!(closed.half_edges().boundary_loops(), 0);
    }
}
