//! Repairs of connectivity: orientation, edges with more than two triangles, vertices with several fans.

use std::collections::VecDeque;

use mesh::{Mesh, sides, triangle};
use petgraph::unionfind::UnionFind;

use super::Mended;

/// Two triangles joined at an edge. `same_way`: both run along it in the same direction, so their orientations disagree.
#[derive(Clone, Copy)]
struct Link {
    triangles: [u32; 2],
    edge: [u32; 2],
    same_way: bool,
}

/// Orients all triangles alike, cuts edges with more than two of them, and splits vertices with several fans.
pub(super) fn mend(mesh: &mut Mesh, mended: &mut Mended) {
    let links = links(mesh, mended);
    let links = orient(mesh, links, mended);
    split_fans(mesh, &links, mended);
    drop_overfull(mesh, mended);
}

/// Joins the triangles at each edge in pairs. If there are more than two, the smoothest pairs are joined first, and a
/// triangle left over stays open there.
fn links(mesh: &Mesh, mended: &mut Mended) -> Vec<Link> {
    let edges = mesh.half_edges();
    let mut links = Vec::with_capacity(3 * mesh.triangles.len() / 2);
    let directed = mesh
        .triangles
        .iter()
        .zip(0..)
        .flat_map(|(&corners, triangle)| sides(corners).map(|(from, to)| (from, to, triangle)));
    for (from, to, triangle) in directed {
        // Each edge once: in the direction from its smaller end, or in the only one there is.
        let is_first = edges.triangles(from, to).next() == Some(triangle);
        if !is_first || from > to && edges.contains(to, from) {
            continue;
        }
        let there = edges.triangles(from, to).map(|triangle| (triangle, true));
        let back = edges.triangles(to, from).map(|triangle| (triangle, false));
        let mut here: Vec<(u32, bool)> = there.chain(back).collect();
        mended.edges_cut += usize::from(here.len() > 2);
        while let Some([a, b]) = smoothest(mesh, &here) {
            links.push(Link {
                triangles: [here[a].0, here[b].0],
                edge: [from, to],
                same_way: here[a].1 == here[b].1,
            });
            here.swap_remove(b);
            here.swap_remove(a);
        }
    }
    links
}

/// The two of an edge's triangles, first index smaller, whose normals differ least among those that run along it in
/// opposite directions. If there are only two, both of them, whatever their directions.
fn smoothest(mesh: &Mesh, here: &[(u32, bool)]) -> Option<[usize; 2]> {
    if here.len() == 2 {
        return Some([0, 1]);
    }
    let normal = |at: usize| triangle::normal(mesh.corners(&mesh.triangles[here[at].0 as usize]));
    let pairs = (0..here.len()).flat_map(|a| (a + 1..here.len()).map(move |b| [a, b]));
    let opposed = pairs.filter(|&[a, b]| here[a].1 != here[b].1);
    opposed.max_by(|&[a, b], &[c, d]| {
        normal(a)
            .dot(&normal(b))
            .total_cmp(&normal(c).dot(&normal(d)))
    })
}

/// Reverses triangles so that linked ones have the same orientation; in each component the minority is reversed. A
/// surface that cannot be oriented, like a Möbius strip, is cut where the orientations meet. Returns the links that stay.
fn orient(mesh: &mut Mesh, links: Vec<Link>, mended: &mut Mended) -> Vec<Link> {
    let mut at_triangle: Vec<Vec<u32>> = vec![Vec::new(); mesh.triangles.len()];
    for (index, link) in links.iter().enumerate() {
        for triangle in link.triangles {
            at_triangle[triangle as usize].push(index as u32);
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    for start in 0..mesh.triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        let mut part = vec![start];
        let mut queue = VecDeque::from([start]);
        while let Some(at) = queue.pop_front() {
            for &link in &at_triangle[at] {
                let link = &links[link as usize];
                let [a, b] = link.triangles.map(|triangle| triangle as usize);
                let other = if a == at { b } else { a };
                if turned[other].is_none() {
                    turned[other] = turned[at].map(|turned| turned ^ link.same_way);
                    part.push(other);
                    queue.push_back(other);
                }
            }
        }
        let count = part.iter().filter(|&&at| turned[at] == Some(true)).count();
        if 2 * count > part.len() {
            for &at in &part {
                turned[at] = turned[at].map(|turned| !turned);
            }
        }
    }
    let is_turned = |triangle: u32| turned[triangle as usize] == Some(true);
    let count = links.len();
    let agrees = |link: &Link| {
        let [a, b] = link.triangles.map(is_turned);
        (a ^ b) == link.same_way
    };
    let kept: Vec<Link> = links.into_iter().filter(agrees).collect();
    mended.edges_cut += count - kept.len();
    for (corners, turned) in mesh.triangles.iter_mut().zip(&turned) {
        if *turned == Some(true) {
            corners.swap(1, 2);
            mended.turned += 1;
        }
    }
    kept
}

/// Splits vertices: each fan of linked triangles gets a vertex of its own, and the first fan keeps the old one.
fn split_fans(mesh: &mut Mesh, links: &[Link], mended: &mut Mended) {
    // Corner 3 t + k is the k-th of triangle t. Corners at the same vertex in linked triangles are one.
    let mut corners: UnionFind<u32> = UnionFind::new(3 * mesh.triangles.len());
    let corner = |mesh: &Mesh, triangle: u32, vertex: u32| {
        let at = mesh.triangles[triangle as usize]
            .iter()
            .position(|&corner| corner == vertex);
        at.map(|at| 3 * triangle + at as u32)
    };
    for link in links {
        for vertex in link.edge {
            let [a, b] = link
                .triangles
                .map(|triangle| corner(mesh, triangle, vertex));
            if let (Some(a), Some(b)) = (a, b) {
                corners.union(a, b);
            }
        }
    }
    let fan_of = corners.into_labeling();
    let mut vertex_of_fan = vec![u32::MAX; fan_of.len()];
    let mut is_used = vec![false; mesh.vertices.len()];
    for (at, fan) in fan_of.into_iter().enumerate() {
        let vertex = &mut mesh.triangles[at / 3][at % 3];
        let old = *vertex as usize;
        let own = &mut vertex_of_fan[fan as usize];
        if *own == u32::MAX {
            *own = old as u32;
            if is_used[old] {
                mended.vertices_split += 1;
                *own = mesh.vertices.len() as u32;
                mesh.vertices.push(mesh.vertices[old]);
            }
            is_used[old] = true;
        }
        *vertex = *own;
    }
}

/// Removes triangles that run along an edge in the same direction as an earlier one.
fn drop_overfull(mesh: &mut Mesh, mended: &mut Mended) {
    let edges = mesh.half_edges();
    let is_first = |(triangle, corners): (u32, &[u32; 3])| {
        let sides = sides(*corners).into_iter();
        sides
            .map(|(from, to)| edges.triangles(from, to).next())
            .all(|first| first == Some(triangle))
    };
    let kept: Vec<bool> = (0..).zip(&mesh.triangles).map(is_first).collect();
    let before = mesh.triangles.len();
    let mut kept = kept.into_iter();
    mesh.triangles.retain(|_| kept.next() == Some(true));
    mended.overfull += before - mesh.triangles.len();
}

/// Reverses the whole mesh if it is inside out: if most of the outermost triangles face inward.
pub(super) fn turn_outward(mesh: &mut Mesh, mended: &mut Mended) {
    let (min, max) = mesh.bounds();
    let centre = nalgebra::center(&min, &max).cast::<f64>();
    // Volume of the cone over each triangle, seen from the middle: for an open mesh, that of the closed one nearly.
    let volume: f64 = mesh
        .triangles
        .iter()
        .map(|corners| {
            let [a, b, c] =
                corners.map(|corner| mesh.vertices[corner as usize].cast::<f64>() - centre);
            a.dot(&b.cross(&c))
        })
        .sum();
    if volume < 0.0 {
        mesh.triangles
            .iter_mut()
            .for_each(|corners| corners.swap(1, 2));
        mended.turned += mesh.triangles.len();
    }
}
