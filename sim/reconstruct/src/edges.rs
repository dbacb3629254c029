//! Which triangle runs along each directed edge.

use mesh::Mesh;

/// The directed edges of a triangle.
pub(crate) fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Directed edges by the vertex that they start at, in the order of their triangles.
pub(crate) struct Edges {
    /// Where each vertex's edges begin, and where the last one's end.
    starts: Vec<u32>,
    /// (end, triangle) of each edge.
    ends: Vec<(u32, u32)>,
}

impl Edges {
    /// The edges of a mesh whose triangles name existing vertices.
    pub fn of(mesh: &Mesh) -> Self {
        let mut starts = vec![0; mesh.vertices.len() + 1];
        for &corner in mesh.triangles.iter().flatten() {
            starts[corner as usize + 1] += 1;
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut ends = vec![(0, 0); 3 * mesh.triangles.len()];
        for (triangle, &corners) in mesh.triangles.iter().enumerate() {
            for (from, to) in sides(corners) {
                let at = &mut next[from as usize];
                ends[*at as usize] = (to, triangle as u32);
                *at += 1;
            }
        }
        Self { starts, ends }
    }

    /// (end, triangle) of the edges that start at a vertex: one for each triangle there.
    pub fn from(&self, vertex: u32) -> &[(u32, u32)] {
        let vertex = vertex as usize;
        &self.ends[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The triangles that run along an edge in this direction.
    pub fn triangles(&self, from: u32, to: u32) -> impl Iterator<Item = u32> {
        let ends = self.from(from).iter();
        ends.filter(move |(end, _)| *end == to)
            .map(|&(_, triangle)| triangle)
    }

    /// Whether any triangle runs along an edge in this direction.
    pub fn contains(&self, from: u32, to: u32) -> bool {
        self.triangles(from, to).next().is_some()
    }
}

/// Number of closed lines of edges that have one triangle.
pub(crate) fn boundary_loops(mesh: &Mesh) -> usize {
    let edges = Edges::of(mesh);
    let open = mesh
        .triangles
        .iter()
        .flat_map(|&corners| sides(corners))
        .filter(|&(from, to)| !edges.contains(to, from));
    let mut next: std::collections::BTreeMap<u32, u32> = open.collect();
    let mut loops = 0;
    while let Some((_, mut at)) = next.pop_first() {
        loops += 1;
        while let Some(to) = next.remove(&at) {
            at = to;
        }
    }
    loops
}
