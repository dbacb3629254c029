//! Triangles that are none, or that are there twice.

use std::collections::HashSet;

use mesh::Mesh;
use nalgebra::Point3;

use super::Mended;
use crate::check::is_flat;
use crate::edges::{Edges, sides};

/// An edge so short, as a share of its triangle's longest, makes the triangle a needle.
const NEEDLE: f64 = 1e-3;

/// Triangles with no area: a needle's two near ends become one vertex, and of a cap, whose one corner lies on the
/// opposite edge, that edge is turned to the corner. What helps neither is left out.
pub(super) fn mend_flat(mesh: &mut Mesh, mended: &mut Mended) {
    drop_repeated(mesh, mended);
    let mut first_of: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut caps = Vec::new();
    for (index, &corners) in mesh.triangles.iter().enumerate() {
        if !is_flat(&mesh.vertices, corners) {
            continue;
        }
        let length = |(a, b): (u32, u32)| {
            let [a, b] = [a, b].map(|corner| mesh.vertices[corner as usize].cast::<f64>());
            (b - a).norm()
        };
        let mut by_length = sides(corners);
        by_length.sort_by(|a, b| length(*a).total_cmp(&length(*b)));
        let [(a, b), _, longest] = by_length;
        if length((a, b)) <= NEEDLE * length(longest) {
            let [a, b] = [a, b].map(|corner| first(&first_of, corner));
            first_of[a.max(b) as usize] = a.min(b);
        } else {
            caps.push((index, longest));
        }
    }
    turn_edges(mesh, &caps, mended);
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = first(&first_of, *corner);
    }
    drop_repeated(mesh, mended);
}

fn first(first_of: &[u32], mut corner: u32) -> u32 {
    while first_of[corner as usize] != corner {
        corner = first_of[corner as usize];
    }
    corner
}

fn drop_repeated(mesh: &mut Mesh, mended: &mut Mended) {
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|&[a, b, c]| a != b && b != c && c != a);
    mended.degenerate += before - mesh.triangles.len();
}

/// Replaces each cap and its neighbour across the longest edge by the two triangles on the other diagonal.
fn turn_edges(mesh: &mut Mesh, caps: &[(usize, (u32, u32))], mended: &mut Mended) {
    if caps.is_empty() {
        return;
    }
    let edges = Edges::of(mesh);
    let mut touched: HashSet<usize> = HashSet::new();
    let mut dropped: HashSet<usize> = HashSet::new();
    for &(cap, (from, to)) in caps {
        let is_sole = edges.triangles(from, to).nth(1).is_none();
        let mut across = edges.triangles(to, from);
        let neighbour = match (across.next(), across.next()) {
            (Some(neighbour), None) if is_sole => Some(neighbour as usize),
            _ => None,
        };
        if touched.contains(&cap) || neighbour.is_some_and(|neighbour| touched.contains(&neighbour))
        {
            // The next round sees what became of it.
            continue;
        }
        let turned = neighbour.and_then(|neighbour| {
            let tip = apex(mesh.triangles[cap], from, to)?;
            let far = apex(mesh.triangles[neighbour], from, to)?;
            let is_taken = edges.contains(tip, far) || edges.contains(far, tip);
            let pair = [[tip, from, far], [tip, far, to]];
            let is_better =
                tip != far && !pair.iter().any(|&corners| is_flat(&mesh.vertices, corners));
            (!is_taken && is_better).then_some((neighbour, pair))
        });
        match turned {
            Some((neighbour, [first, second])) => {
                mesh.triangles[cap] = first;
                mesh.triangles[neighbour] = second;
                touched.extend([cap, neighbour]);
                mended.degenerate += 1;
            }
            None => {
                dropped.insert(cap);
            }
        }
    }
    mended.degenerate += dropped.len();
    let mut index = 0;
    mesh.triangles.retain(|_| {
        index += 1;
        !dropped.contains(&(index - 1))
    });
}

fn apex(corners: [u32; 3], from: u32, to: u32) -> Option<u32> {
    corners
        .into_iter()
        .find(|&corner| corner != from && corner != to)
}

/// Keeps the first of the triangles that have the same three corners, whichever way they turn.
pub(super) fn drop_duplicates(mesh: &mut Mesh, mended: &mut Mended) {
    let edges = Edges::of(mesh);
    let before = mesh.triangles.len();
    let corners_of = |triangle: u32| {
        let mut corners = mesh.triangles[triangle as usize];
        corners.sort_unstable();
        corners
    };
    let is_first = |triangle: u32| {
        let corners = corners_of(triangle);
        let at = edges.from(corners[0]).iter().map(|&(_, other)| other);
        at.filter(|&other| other < triangle)
            .all(|other| corners_of(other) != corners)
    };
    let kept: Vec<bool> = (0..before as u32).map(is_first).collect();
    let mut kept = kept.into_iter();
    mesh.triangles.retain(|_| kept.next() == Some(true));
    mended.duplicate += before - mesh.triangles.len();
}

/// Unit normal of a triangle; zero where it has no area.
pub(super) fn normal(vertices: &[Point3<f32>], corners: [u32; 3]) -> nalgebra::Vector3<f64> {
    let [a, b, c] = corners.map(|corner| vertices[corner as usize].cast::<f64>());
    (b - a)
        .cross(&(c - a))
        .try_normalize(0.0)
        .unwrap_or_default()
}
