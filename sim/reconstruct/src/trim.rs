//! Poisson closes every hole with a balloon; what no sample supports goes.

use cloud::Tree;
use nalgebra::Point3;

use crate::poisson::{Field, Surface};

/// Distance, as a share of the reach, of a surface point from the mean of the samples within reach of it, beyond which it
/// lies outside them. On the straight edge of a surface it is 4/(3π) = 0.42.
const OFF_CENTRE_MAX: f64 = 0.45;

/// Leaves out triangles with a corner beyond the samples' edge, and says how many. Holes of the samples narrower than
/// about `reach_m` stay closed, since there are samples on all sides of them.
pub(crate) fn trim(
    surface: &mut Surface,
    field: &Field,
    samples: &Tree,
    sample_points: &[Point3<f32>],
    reach_m: f64,
) -> usize {
    let is_supported = |point: &Point3<f64>| {
        let (mut sum, mut count) = (nalgebra::Vector3::zeros(), 0.0);
        for near in samples.within(&point.cast(), reach_m as f32) {
            sum += sample_points[near.index].coords.cast::<f64>() - point.coords;
            count += 1.0;
        }
        if count == 0.0 {
            return false;
        }
        let offset: nalgebra::Vector3<f64> = sum / count;
        // Where the surface bends, samples lie on one side of it; only the distance along it counts.
        let normal = field
            .project(point)
            .map(|(_, normal)| normal)
            .unwrap_or_default();
        let along = offset - normal * normal.dot(&offset);
        along.norm() <= OFF_CENTRE_MAX * reach_m
    };
    let supported: Vec<bool> = {
        use rayon::prelude::*;
        surface.points.par_iter().map(is_supported).collect()
    };
    let before = surface.triangles.len();
    surface
        .triangles
        .retain(|triangle| triangle.iter().all(|&corner| supported[corner as usize]));
    before - surface.triangles.len()
}
