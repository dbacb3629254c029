//! Which deviations are dents, and what each is like.

use nalgebra::{Point3, Vector3};

use crate::bottom::{self, Bottom};
use crate::field::Field;
use crate::parameters::Parameters;
use crate::reference::{Reference, tangents};

/// A dent on the reference, before it is put into frames.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    pub centre: Point3<f64>,
    pub normal: Vector3<f64>,
    pub depth_m: f64,
    pub depth_sigma_m: f64,
    pub significance: f64,
    pub width_m: f64,
    pub height_m: f64,
    pub area_m2: f64,
}

/// Connected sites that lie significantly inside, the deepest dent first. Thresholds have hysteresis, as in Canny's edge
/// detector (1986): at least one site of a dent must exceed them, and its other sites must exceed half of them.
pub(crate) fn patches(reference: &Reference, field: &Field, parameters: &Parameters) -> Vec<Patch> {
    let mut patches = candidates(reference, field, parameters);
    patches.retain(|patch| {
        patch.depth_m >= parameters.depth_min_m
            && patch.significance >= parameters.significance_min
            && patch.area_m2 >= parameters.area_min_m2
    });
    patches.sort_by(|a, b| b.depth_m.total_cmp(&a.depth_m));
    patches
}

/// All that lies inside by more than noise, in no order.
pub(crate) fn candidates(
    reference: &Reference,
    field: &Field,
    parameters: &Parameters,
) -> Vec<Patch> {
    let sites = &reference.sites;
    let significance = |site: usize| field.of_site[site].significance();
    let reach_m = 0.4 * parameters.depth_min_m;
    let reaches = |site: usize| {
        significance(site) > 0.5 * parameters.significance_min
            && -field.of_site[site].off_m > reach_m
    };
    let mut taken = vec![false; sites.list.len()];
    let mut patches = Vec::new();
    for first in 0..sites.list.len() {
        if taken[first] || !reaches(first) {
            continue;
        }
        let (mut members, mut next) = (vec![first], 0);
        taken[first] = true;
        while let Some(&site) = members.get(next) {
            next += 1;
            for beside in sites.beside(site) {
                if !taken[beside] && reaches(beside) {
                    taken[beside] = true;
                    members.push(beside);
                }
            }
        }
        patches.extend(patch(reference, field, &members, &significance));
    }
    patches
}

fn patch(
    reference: &Reference,
    field: &Field,
    members: &[usize],
    significance: &impl Fn(usize) -> f64,
) -> Option<Patch> {
    let sites = &reference.sites.list;
    let inside_m = |site: usize| -field.of_site[site].off_m;
    let deepest = *members
        .iter()
        .max_by(|&&a, &&b| inside_m(a).total_cmp(&inside_m(b)))?;
    let Bottom { depth_m, sigma_m } =
        bottom::bottom(&sites[deepest], &field.of_site[deepest], field);
    let bottom_m = 0.7 * inside_m(deepest);
    let bottom = members.iter().filter(|&&site| inside_m(site) >= bottom_m);
    let (mut sum, mut normal, mut weights) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for &site in bottom {
        let weight = f64::from(sites[site].area_m2) * inside_m(site);
        sum += sites[site].point.coords.cast::<f64>() * weight;
        normal += sites[site].normal.cast::<f64>() * weight;
        weights += weight;
    }
    let centre = Point3::from(sum / weights);
    let on_surface = reference.outer.nearest(&centre.cast());
    let normal = normal.try_normalize(1e-12)?;
    let [across, up] = tangents(&normal.cast());
    let extent = |direction: &Vector3<f32>| {
        let along = members
            .iter()
            .map(|&site| direction.dot(&sites[site].point.coords));
        let (low, high) = along.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
        f64::from(high - low) + f64::from(sites[deepest].area_m2).sqrt()
    };
    Some(Patch {
        centre: reference.outer.samples[on_surface].point.cast(),
        normal,
        depth_m,
        depth_sigma_m: sigma_m,
        significance: members.iter().map(|&s| significance(s)).fold(0.0, f64::max),
        width_m: extent(&across),
        height_m: extent(&up),
        area_m2: members.iter().map(|&s| f64::from(sites[s].area_m2)).sum(),
    })
}
