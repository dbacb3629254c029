//! Poisson reconstruction closes every hole with a bulging surface. Trimming removes the parts that no sample supports.

use cloud::Tree;
use mesh::triangle;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::poisson::{Field, Surface};

/// A surface point is unsupported if the centroid of the samples within reach is farther from it than this share of the
/// reach. For a point on the straight edge of a sampled surface this is the centroid of a half disc, 4/(3π) = 0.42.
const OFF_CENTRE_MAX: f64 = 0.45;
/// A surface point nearer to a sample than this share of the reach is kept in any case: at a sharp corner of the samples
/// the centroid is far away.
const NEAR: f64 = 0.15;

/// Removes the parts of a surface beyond the samples' edge and returns the number of triangles removed. Holes of the
/// samples narrower than about `reach_m` stay closed, since there are samples on all sides of them.
pub(crate) fn trim(
    surface: &mut Surface,
    field: &Field,
    samples: &Tree,
    sample_points: &[Point3<f32>],
    reach_m: f64,
) -> usize {
    let is_supported = |point: &Point3<f64>| {
        let (mut offset, mut count, mut nearest_sq) = (Vector3::zeros(), 0.0, f32::INFINITY);
        for near in samples.within(&point.cast(), reach_m as f32) {
            offset += sample_points[near.index].coords.cast::<f64>() - point.coords;
            count += 1.0;
            nearest_sq = nearest_sq.min(near.distance_sq);
        }
        if f64::from(nearest_sq) <= (NEAR * reach_m).powi(2) {
            return true;
        }
        // Where the surface bends, samples lie on one side of it; only the offset along the surface counts.
        let normal = field
            .project(point)
            .map(|(_, normal)| normal)
            .unwrap_or_default();
        let along = offset - normal * normal.dot(&offset);
        count > 0.0 && along.norm() <= OFF_CENTRE_MAX * reach_m * count
    };
    let supported: Vec<bool> = surface.points.par_iter().map(is_supported).collect();
    let is_kept = |corners: &[u32; 3]| corners.iter().all(|&corner| supported[corner as usize]);
    let (mut kept, trimmed): (Vec<_>, Vec<_>) = surface
        .triangles
        .iter()
        .partition(|corners| is_kept(corners));
    let before = surface.triangles.len();
    kept.extend(pinholes(surface, &trimmed, reach_m));
    surface.triangles = kept;
    before - surface.triangles.len()
}

/// Trimmed triangles that would leave only a pinhole: components with less area than a hole that stays closed.
fn pinholes(surface: &Surface, trimmed: &[[u32; 3]], reach_m: f64) -> Vec<[u32; 3]> {
    let (part_of, count) = mesh::components(surface.points.len(), trimmed);
    let mut areas = vec![0.0; count];
    let part = |corners: &[u32; 3]| part_of[corners[0] as usize] as usize;
    for corners in trimmed {
        areas[part(corners)] +=
            triangle::area(corners.map(|corner| surface.points[corner as usize]));
    }
    let is_small = |corners: &&[u32; 3]| areas[part(corners)] < reach_m * reach_m;
    trimmed.iter().filter(is_small).copied().collect()
}
