//! Isotropic incremental remeshing: edges of nearly one length, chosen so that the wanted number of vertices results.
//!
//! After Botsch and Kobbelt, "A remeshing approach to multiresolution modeling" (SGP 2004): each round splits long edges,
//! collapses short ones, flips edges to equalise valences, and relaxes vertices tangentially.

mod change;
mod connect;

use mesh::triangle;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::poisson::Surface;
use connect::Connected;

/// Longest and shortest edges, as shares of the wanted length (Botsch and Kobbelt, Sec. 4).
const LONG: f64 = 4.0 / 3.0;
const SHORT: f64 = 4.0 / 5.0;
/// Damping of tangential relaxation: share of the way to the neighbours' centroid that a vertex moves.
const RELAXATION: f64 = 0.6;
const ROUNDS_MIN: usize = 6;
const ROUNDS_MAX: usize = 14;
/// How near the wanted count is near enough, as a share of it.
const TOLERANCE: f64 = 0.03;

/// Moves a point onto the surface and gives the normal there; `None` away from it.
pub(crate) trait Project:
    Fn(&Point3<f64>) -> Option<(Point3<f64>, Vector3<f64>)> + Sync
{
}
impl<F: Fn(&Point3<f64>) -> Option<(Point3<f64>, Vector3<f64>)> + Sync> Project for F {}

/// Remeshes a manifold surface to about `wanted` vertices.
pub(crate) fn to_count(surface: Surface, wanted: usize, project: impl Project) -> Surface {
    let mut length = edge_length(&surface, wanted);
    let mut mesh = Connected::new(surface);
    for round in 1..=ROUNDS_MAX {
        split_long(&mut mesh, LONG * length, &project);
        collapse_short(&mut mesh, SHORT * length, LONG * length);
        flip_edges(&mut mesh);
        relax(&mut mesh, &project);
        let ratio = mesh.vertex_count() as f64 / wanted as f64;
        if round >= ROUNDS_MIN && (ratio - 1.0).abs() <= TOLERANCE {
            break;
        }
        if round > 2 {
            length *= ratio.sqrt().clamp(0.8, 1.25);
        }
    }
    // Vertices that were not allowed to relax may still lie off the surface.
    let settled: Vec<Point3<f64>> = mesh
        .points
        .par_iter()
        .map(|point| project(point).map_or(*point, |(place, _)| place))
        .collect();
    mesh.move_unfolded(&settled);
    mesh.into_surface()
}

/// Edge length of equilateral triangles that cover the surface with about `wanted` vertices, two triangles each.
fn edge_length(surface: &Surface, wanted: usize) -> f64 {
    let area: f64 = surface
        .triangles
        .iter()
        .map(|corners| triangle::area(corners.map(|corner| surface.points[corner as usize])))
        .sum();
    (area / (2.0 * wanted as f64) * 4.0 / 3.0_f64.sqrt()).sqrt()
}

fn split_long(mesh: &mut Connected, longest: f64, project: &impl Project) {
    let mut edges = mesh.edges_by_length(|length| length > longest);
    edges.reverse();
    for [a, b] in edges {
        let middle = nalgebra::center(&mesh.points[a as usize], &mesh.points[b as usize]);
        let place = project(&middle).map_or(middle, |(place, _)| place);
        mesh.split([a, b], place);
    }
}

fn collapse_short(mesh: &mut Connected, shortest: f64, longest: f64) {
    for [a, b] in mesh.edges_by_length(|length| length < shortest) {
        // Earlier collapses may have moved or joined the ends.
        if mesh.has_edge(a, b) && mesh.length(a, b) < shortest {
            mesh.collapse(a, b, longest);
        }
    }
}

/// Flips an edge where this brings the valences of the four vertices around it nearer to 6 (on a boundary: 4).
fn flip_edges(mesh: &mut Connected) {
    let edges: Vec<[u32; 2]> = mesh.edges().collect();
    for [a, b] in edges {
        let Some([c, d]) = mesh.opposite(a, b) else {
            continue;
        };
        let excess = |vertex: u32, change: i32| {
            let ideal = if mesh.is_boundary(vertex) { 4 } else { 6 };
            (mesh.valence(vertex) as i32 + change - ideal).pow(2)
        };
        let now = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
        let then = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
        if then < now {
            mesh.flip([a, b], [c, d]);
        }
    }
}

/// Tangential relaxation: moves vertices along the surface towards the centroid of their neighbours; boundary vertices move
/// along the boundary.
fn relax(mesh: &mut Connected, project: &impl Project) {
    let moved = |vertex: u32| {
        let from = mesh.points[vertex as usize];
        let ring = mesh.smoothing_ring(vertex);
        if ring.is_empty() {
            return from;
        }
        let sum: Vector3<f64> = ring
            .iter()
            .map(|&other| mesh.points[other as usize].coords)
            .sum();
        let step = (sum / ring.len() as f64 - from.coords) * RELAXATION;
        let normal = mesh.normal(vertex);
        let along = from + (step - normal * normal.dot(&step));
        match project(&along) {
            // Near the other side of a thin wall the projection may land on that side.
            Some((place, outward)) if outward.dot(&normal) > 0.5 => place,
            _ => along,
        }
    };
    let moved: Vec<Point3<f64>> = (0..mesh.points.len() as u32)
        .into_par_iter()
        .map(moved)
        .collect();
    mesh.move_unfolded(&moved);
}
