//! Even triangles: edges of nearly one length, so that the wanted number of vertices comes out.
//!
//! After Botsch and Kobbelt, "A remeshing approach to multiresolution modeling" (SGP 2004): long edges are split, short
//! ones collapsed, edges turned where that evens out how many meet at a vertex, and vertices slid along the surface.

mod change;
mod connect;

use mesh::triangle;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::poisson::Surface;
use connect::Connected;

/// Longest and shortest edges, as shares of the wanted length.
const LONG: f64 = 4.0 / 3.0;
const SHORT: f64 = 4.0 / 5.0;
/// How far a vertex slides towards the middle of its neighbours.
const SLIDE: f64 = 0.6;
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

/// Gives a manifold surface about `wanted` vertices.
pub(crate) fn to_count(surface: Surface, wanted: usize, project: impl Project) -> Surface {
    let mut length = edge_length(&surface, wanted);
    let mut mesh = Connected::new(surface);
    for round in 1..=ROUNDS_MAX {
        split_long(&mut mesh, LONG * length, &project);
        collapse_short(&mut mesh, SHORT * length, LONG * length);
        turn_uneven(&mut mesh);
        slide(&mut mesh, &project);
        let ratio = mesh.vertex_count() as f64 / wanted as f64;
        if round >= ROUNDS_MIN && (ratio - 1.0).abs() <= TOLERANCE {
            break;
        }
        if round > 2 {
            length *= ratio.sqrt().clamp(0.8, 1.25);
        }
    }
    // What was refused to slide still lies off the surface.
    let settled: Vec<Point3<f64>> = mesh
        .points
        .par_iter()
        .map(|point| project(point).map_or(*point, |(place, _)| place))
        .collect();
    mesh.move_unfolded(&settled);
    mesh.into_surface()
}

/// Edge of equilateral triangles of which the surface holds twice as many as `wanted`.
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

/// Turns an edge where the four vertices about it then have more nearly six neighbours, on a boundary four.
fn turn_uneven(mesh: &mut Connected) {
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
            mesh.turn([a, b], [c, d]);
        }
    }
}

/// Moves vertices towards the middle of their neighbours, along the surface; those on a boundary along that.
fn slide(mesh: &mut Connected, project: &impl Project) {
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
        let step = (sum / ring.len() as f64 - from.coords) * SLIDE;
        let normal = mesh.normal(vertex);
        let along = from + (step - normal * normal.dot(&step));
        match project(&along) {
            // Near a thin wall's other side the projection may jump over.
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
