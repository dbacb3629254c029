//! Mesh repair: makes a mesh meet the conditions of [`check`](crate::check::check).

mod faces;
mod topology;

use std::collections::HashMap;

use mesh::{Mesh, triangle};
use serde::Serialize;

use crate::check;

/// Number of repairs, by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Mended {
    /// Vertices at the very place of another, joined to it.
    pub vertices_joined: usize,
    /// Triangles that named a vertex twice, or had no area and were left out or folded into their neighbours.
    pub degenerate: usize,
    /// Triangles with the same three vertices as another, left out.
    pub duplicate: usize,
    /// Edges with more than two triangles, or on which the sides of a one-sided surface met, cut open.
    pub edges_cut: usize,
    /// Triangles removed because an edge still had more than two.
    pub overfull: usize,
    /// Vertices at which several fans met, duplicated once for each further fan.
    pub vertices_split: usize,
    /// Triangles whose orientation was reversed.
    pub turned: usize,
    /// Connected components removed: all but the largest.
    pub components_dropped: usize,
    /// Triangles of the removed components.
    pub component_triangles: usize,
    /// Vertices removed because no triangle used them.
    pub unused: usize,
}

/// Rounds of repair at most: each can uncover faults that others hid before.
const ROUNDS_MAX: usize = 8;

/// Mends a mesh whose triangles name existing, finite vertices.
pub(crate) fn clean(mesh: Mesh) -> (Mesh, Mended) {
    let mut mended = Mended::default();
    let mut mesh = mesh;
    join_vertices(&mut mesh, &mut mended);
    for _ in 0..ROUNDS_MAX {
        faces::mend_flat(&mut mesh, &mut mended);
        faces::drop_duplicates(&mut mesh, &mut mended);
        topology::mend(&mut mesh, &mut mended);
        keep_largest(&mut mesh, &mut mended);
        drop_unused(&mut mesh, &mut mended);
        if check::check(&mesh).is_ok() || mesh.triangles.is_empty() {
            break;
        }
    }
    topology::turn_outward(&mut mesh, &mut mended);
    (mesh, mended)
}

/// Joins vertices at exactly the same place, as in files that give each triangle its own three.
fn join_vertices(mesh: &mut Mesh, mended: &mut Mended) {
    let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(mesh.vertices.len());
    let mut first_of = Vec::with_capacity(mesh.vertices.len());
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        // Adding 0 makes −0 and 0 the same.
        let place = [vertex.x, vertex.y, vertex.z].map(|coordinate| (coordinate + 0.0).to_bits());
        let first = *first_at.entry(place).or_insert(index as u32);
        mended.vertices_joined += usize::from(first != index as u32);
        first_of.push(first);
    }
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = first_of[*corner as usize];
    }
    if mended.vertices_joined > 0 {
        // Joined vertices are counted above; do not count them as unused, too.
        drop_unused(mesh, &mut Mended::default());
    }
}

/// Keeps the component with the largest area.
fn keep_largest(mesh: &mut Mesh, mended: &mut Mended) {
    let (component_of, count) = mesh::components(mesh.vertices.len(), &mesh.triangles);
    if count < 2 {
        return;
    }
    let mut areas = vec![0.0; count];
    for corners in &mesh.triangles {
        areas[component_of[corners[0] as usize] as usize] += triangle::area(mesh.corners(corners));
    }
    let largest = (0..count).max_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(b.cmp(&a)));
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|corners| Some(component_of[corners[0] as usize] as usize) == largest);
    mended.components_dropped += count - 1;
    mended.component_triangles += before - mesh.triangles.len();
}

/// Leaves out vertices that no triangle uses; the others keep their order.
fn drop_unused(mesh: &mut Mesh, mended: &mut Mended) {
    let mut used = vec![false; mesh.vertices.len()];
    for &corner in mesh.triangles.iter().flatten() {
        used[corner as usize] = true;
    }
    let mut kept = Vec::with_capacity(mesh.vertices.len());
    let mut new_index = vec![0; mesh.vertices.len()];
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        new_index[index] = kept.len() as u32;
        if used[index] {
            kept.push(*vertex);
        }
    }
    mended.unused += mesh.vertices.len() - kept.len();
    mesh.vertices = kept;
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = new_index[*corner as usize];
    }
}
