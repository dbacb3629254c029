//! The same surface with fewer vertices, spread evenly.
//!
//! Triangles are first divided until none is long; then vertices a spacing apart are chosen, each takes the vertices that
//! are nearest to it along edges, and three whose parts meet in a triangle become one: the dual of a Voronoi diagram on the
//! surface, as in Valette and Chassery, "Approximated centroidal Voronoi diagrams for uniform polygonal mesh
//! coarsening", Eurographics 2004, without their iterations.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use mesh::Mesh;
use nalgebra::Point3;

/// Edges are at most this share of the spacing before vertices are chosen.
const FINE: f32 = 0.35;
/// An edge of 1 m becomes pieces of a millimetre.
const DIVISIONS_MAX: usize = 10;
/// Long thin triangles are not divided any further from here on.
const TRIANGLES_MAX: usize = 400_000;

/// A mesh whose vertices are about `spacing_m` apart. Its triangles face as the mesh's; only its largest connected part is kept.
pub(super) fn resampled(mesh: &Mesh, spacing_m: f32) -> Mesh {
    let fine = divided(mesh, FINE * spacing_m);
    let owners = owners(&fine, spacing_m);
    let mut seen = HashSet::new();
    let mut triangles = Vec::new();
    for triangle in &fine.triangles {
        let [a, b, c] = triangle.map(|vertex| owners[vertex as usize]);
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        if a != b && b != c && c != a && a.max(b).max(c) != NOBODY && seen.insert(sorted) {
            triangles.push([a, b, c]);
        }
    }
    compacted(&fine.vertices, largest_part(fine.vertices.len(), triangles))
}

/// Splits edges in their middles until none is longer.
fn divided(mesh: &Mesh, edge_max_m: f32) -> Mesh {
    let mut mesh = mesh.clone();
    for _ in 0..DIVISIONS_MAX {
        let mut middles = HashMap::new();
        let Mesh {
            vertices,
            triangles,
        } = &mut mesh;
        let mut next = Vec::with_capacity(2 * triangles.len());
        for &[a, b, c] in triangles.iter() {
            let mut middle = |a: u32, b: u32| {
                let [p, q] = [a, b].map(|index| vertices[index as usize]);
                ((p - q).norm() > edge_max_m).then(|| {
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        vertices.push(nalgebra::center(&p, &q));
                        vertices.len() as u32 - 1
                    })
                })
            };
            next.extend(split([a, b, c], [middle(a, b), middle(b, c), middle(c, a)]));
        }
        *triangles = next;
        if middles.is_empty() || triangles.len() > TRIANGLES_MAX {
            break;
        }
    }
    mesh
}

/// A triangle with middles on some of its sides ab, bc and ca.
fn split(corners: [u32; 3], middles: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    for turn in 0..3 {
        let [a, b, c] = [0, 1, 2].map(|k| corners[(k + turn) % 3]);
        match [0, 1, 2].map(|k| middles[(k + turn) % 3]) {
            [Some(ab), Some(bc), Some(ca)] => {
                return vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            }
            [Some(ab), Some(bc), None] => return vec![[a, ab, c], [ab, b, bc], [ab, bc, c]],
            [Some(ab), None, None] => return vec![[a, ab, c], [ab, b, c]],
            _ => {}
        }
    }
    vec![corners]
}

const NOBODY: u32 = u32::MAX;

/// For each vertex the chosen one that is nearest along edges; [`NOBODY`] for a vertex without a triangle.
fn owners(mesh: &Mesh, spacing_m: f32) -> Vec<u32> {
    let rings = mesh.half_edges().one_rings();
    let count = mesh.vertices.len();
    let (mut owners, mut nearest_m) = (vec![NOBODY; count], vec![f32::MAX; count]);
    let mut queue = BinaryHeap::new();
    for first in 0..count {
        if nearest_m[first] < spacing_m || rings.of(first).is_empty() {
            continue;
        }
        // Distances are not negative: their bits sort as they do.
        queue.push(Reverse((0u32, first)));
        (nearest_m[first], owners[first]) = (0.0, first as u32);
        while let Some(Reverse((distance, vertex))) = queue.pop() {
            let distance_m = f32::from_bits(distance);
            if distance_m > nearest_m[vertex] {
                continue;
            }
            for &beside in rings.of(vertex) {
                let beside = beside as usize;
                let way_m = (mesh.vertices[vertex] - mesh.vertices[beside]).norm();
                let reached_m = distance_m + way_m;
                if reached_m < nearest_m[beside] {
                    (nearest_m[beside], owners[beside]) = (reached_m, first as u32);
                    queue.push(Reverse((reached_m.to_bits(), beside)));
                }
            }
        }
    }
    owners
}

/// Without triangles that lie apart: at a rim a few of the inside may count as outside.
fn largest_part(vertices: usize, triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let (part_of, parts) = mesh::components(vertices, &triangles);
    let part = |triangle: &[u32; 3]| part_of[triangle[0] as usize] as usize;
    let mut sizes = vec![0; parts];
    triangles.iter().for_each(|t| sizes[part(t)] += 1);
    let largest = (0..parts).max_by_key(|&part| sizes[part]);
    let mut triangles = triangles;
    triangles.retain(|t| Some(part(t)) == largest);
    triangles
}

/// Without the vertices that no triangle names.
fn compacted(vertices: &[Point3<f32>], mut triangles: Vec<[u32; 3]>) -> Mesh {
    let mut names = HashMap::new();
    let mut kept = Vec::new();
    for vertex in triangles.iter_mut().flatten() {
        *vertex = *names.entry(*vertex).or_insert_with(|| {
            kept.push(vertices[*vertex as usize]);
            kept.len() as u32 - 1
        });
    }
    Mesh {
        vertices: kept,
        triangles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_cylinder_becomes_an_even_mesh_of_the_same_surface() {
        let cylinder = Mesh::cylinder(0.033, 0.0, 0.12, 48);
        let even = resampled(&cylinder, 0.006);
        assert!(even.is_closed_manifold());
        assert!(
            (700..2500).contains(&even.vertices.len()),
            "{}",
            even.vertices.len()
        );
        assert!((even.area_m2() / cylinder.area_m2() - 1.0).abs() < 0.03);
        assert!((even.volume_m3() / cylinder.volume_m3() - 1.0).abs() < 0.03);
        for edge in even.half_edges().edges() {
            let [a, b] = edge.ends.map(|index| even.vertices[index as usize]);
            assert!((0.003..0.014).contains(&(a - b).norm()), "{a} {b}");
        }
    }
}
