//! Degenerate and duplicate triangles.

use std::collections::HashSet;

use mesh::{Mesh, sides};
use petgraph::unionfind::UnionFind;

use super::Mended;
use crate::check::is_flat;

/// A degenerate triangle with an edge shorter than this share of its longest is a needle, otherwise a cap.
const NEEDLE: f64 = 1e-3;

/// Mends degenerate triangles: collapses the short edge of a needle, and flips the longest edge of a cap (whose third
/// corner lies on that edge). Triangles that neither helps are removed.
pub(super) fn mend_flat(mesh: &mut Mesh, mended: &mut Mended) {
    drop_repeated(mesh, mended);
    let mut joined: UnionFind<u32> = UnionFind::new(mesh.vertices.len());
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
            joined.union(a, b);
        } else {
            caps.push((index, longest));
        }
    }
    turn_edges(mesh, &caps, mended);
    let first_of = first_of_each(joined);
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = first_of[*corner as usize];
    }
    drop_repeated(mesh, mended);
}

/// For each member the first member of its set.
fn first_of_each(sets: UnionFind<u32>) -> Vec<u32> {
    let sets = sets.into_labeling();
    let mut first_of_set = vec![u32::MAX; sets.len()];
    for (member, &set) in (0..).zip(&sets) {
        first_of_set[set as usize] = first_of_set[set as usize].min(member);
    }
    sets.iter().map(|&set| first_of_set[set as usize]).collect()
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
    let edges = mesh.half_edges();
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
            // An earlier flip changed one of the two; the next round tests them again.
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
    let edges = mesh.half_edges();
    let before = mesh.triangles.len();
    let corners_of = |triangle: u32| {
        let mut corners = mesh.triangles[triangle as usize];
        corners.sort_unstable();
        corners
    };
    let is_first = |triangle: u32| {
        let corners = corners_of(triangle);
        let at = edges.from(corners[0]).iter().map(|edge| edge.triangle);
        at.filter(|&other| other < triangle)
            .all(|other| corners_of(other) != corners)
    };
    let kept: Vec<bool> = (0..before as u32).map(is_first).collect();
    let mut kept = kept.into_iter();
    mesh.triangles.retain(|_| kept.next() == Some(true));
    mended.duplicate += before - mesh.triangles.len();
}
