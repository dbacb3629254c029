//! The laws that a mesh must keep to be deformed.

use std::collections::HashMap;

use nalgebra::Point3;
use sim_objects::Mesh;

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
    #[error("the triangles at vertex {vertex} form {fans} fans")]
    Fans {
        /// Its index.
        vertex: u32,
        /// How many.
        fans: usize,
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
    let edges = directed_edges(mesh)?;
    check_fans(mesh, &edges)?;
    match components(mesh).1 {
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

/// The triangle of each directed edge.
fn directed_edges(mesh: &Mesh) -> Result<HashMap<(u32, u32), usize>, Defect> {
    let mut edges = HashMap::with_capacity(3 * mesh.triangles.len());
    for (triangle, &corners) in mesh.triangles.iter().enumerate() {
        for (from, to) in sides(corners) {
            if edges.insert((from, to), triangle).is_some() {
                return Err(Defect::Edge { from, to });
            }
        }
    }
    Ok(edges)
}

/// The directed edges of a triangle.
pub(crate) fn sides([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// A fan is a path of triangles, each sharing an edge with the next; a closed one has no first.
fn check_fans(mesh: &Mesh, edges: &HashMap<(u32, u32), usize>) -> Result<(), Defect> {
    let mut triangles_at = vec![0; mesh.vertices.len()];
    let mut fan_at = vec![None; mesh.vertices.len()];
    for &corners in &mesh.triangles {
        for (from, to) in sides(corners) {
            triangles_at[from as usize] += 1;
            // A fan starts where nothing comes before its first edge; any edge starts a closed one.
            if fan_at[from as usize].is_none() || !edges.contains_key(&(to, from)) {
                fan_at[from as usize] = Some(to);
            }
        }
    }
    for (vertex, (&count, &first)) in triangles_at.iter().zip(&fan_at).enumerate() {
        let vertex = vertex as u32;
        let Some(first) = first else {
            return Err(Defect::Unused { vertex });
        };
        let mut seen = 0;
        let mut next = Some(first);
        while let Some(&triangle) = next.and_then(|to| edges.get(&(vertex, to))) {
            seen += 1;
            let corners = mesh.triangles[triangle];
            // The edge that leads back to the vertex.
            next = sides(corners)
                .iter()
                .find(|(_, to)| *to == vertex)
                .map(|(from, _)| *from);
            if next == Some(first) || seen > count {
                break;
            }
        }
        if seen != count {
            return Err(Defect::Fans { vertex, fans: 2 });
        }
    }
    Ok(())
}

/// The component of each vertex, numbered in order of their first triangles, and how many there are.
pub(crate) fn components(mesh: &Mesh) -> (Vec<u32>, usize) {
    let mut parents: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    fn root(parents: &mut [u32], mut at: u32) -> u32 {
        while parents[at as usize] != at {
            let above = parents[parents[at as usize] as usize];
            parents[at as usize] = above;
            at = above;
        }
        at
    }
    for &[a, b, c] in &mesh.triangles {
        for other in [b, c] {
            let (a, other) = (root(&mut parents, a), root(&mut parents, other));
            parents[a.max(other) as usize] = a.min(other);
        }
    }
    let mut numbers = vec![u32::MAX; mesh.vertices.len()];
    let mut count = 0;
    for corner in mesh.triangles.iter().flatten() {
        let root = root(&mut parents, *corner) as usize;
        if numbers[root] == u32::MAX {
            numbers[root] = count;
            count += 1;
        }
        numbers[*corner as usize] = numbers[root];
    }
    (numbers, count as usize)
}

/// Number of closed lines of edges that have one triangle.
pub(crate) fn boundary_loops(mesh: &Mesh) -> usize {
    let directed: std::collections::HashSet<(u32, u32)> = mesh
        .triangles
        .iter()
        .flat_map(|&corners| sides(corners))
        .collect();
    let mut next: std::collections::BTreeMap<u32, u32> = directed
        .iter()
        .filter(|&&(from, to)| !directed.contains(&(to, from)))
        .map(|&(from, to)| (from, to))
        .collect();
    let mut loops = 0;
    while let Some((_, mut at)) = next.pop_first() {
        loops += 1;
        while let Some(to) = next.remove(&at) {
            at = to;
        }
    }
    loops
}
