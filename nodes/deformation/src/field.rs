//! How far the cloud lies off the reference, point by point and averaged over the surface.

use nalgebra::{Point3, Vector3};

use crate::fit::cameras;
use crate::observation::{Cameras, Observation, sigma_m};
use crate::parameters::Parameters;
use crate::placement::Placement;
use crate::reference::Reference;

/// Farther from the surface than this is not the object's.
const OFF_MAX_M: f64 = 0.022;
/// Farther beside the nearest sample than this is beyond an edge.
const BESIDE_MAX_M: f64 = 0.004;

/// A point of the cloud on the outer surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deviation {
    /// Along the reference's normal, m; negative inside.
    pub off_m: f64,
    pub sigma_m: f64,
    pub site: u32,
}

/// A site's surroundings.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Average {
    /// Mean deviation of the points there, m; negative inside.
    pub off_m: f64,
    /// Standard deviation of that mean, m.
    pub sigma_m: f64,
    /// Points there.
    pub count: usize,
}

impl Average {
    /// How many standard deviations the surface lies inside; 0 for what was not seen.
    pub(crate) fn significance(&self) -> f64 {
        if self.is_seen() {
            -self.off_m / self.sigma_m
        } else {
            0.0
        }
    }

    /// Whether enough points are there to say anything.
    pub(crate) fn is_seen(&self) -> bool {
        /// Fewer points around a site say nothing about it.
        const SEEN_POINTS: usize = 4;
        self.count >= SEEN_POINTS
    }
}

/// Deviations of a cloud.
pub(crate) struct Field {
    /// Of each point; `None` for what is not on the outer surface.
    pub of_point: Vec<Option<Deviation>>,
    /// On the reference, in the order of the points.
    pub places: Vec<Point3<f64>>,
    /// Of each site.
    pub of_site: Vec<Average>,
    /// Root mean square of the deviations of points that lie within a few standard deviations, m.
    pub rms_m: f64,
}

impl Field {
    pub(crate) fn new(
        reference: &Reference,
        seen: &Observation<'_>,
        placement: &Placement,
        parameters: &Parameters,
    ) -> Self {
        let cameras = cameras(seen, placement);
        let places: Vec<_> = seen
            .points
            .iter()
            .map(|point| placement.on_reference(&point.cast()))
            .collect();
        let of_point: Vec<_> = places
            .iter()
            .map(|place| deviation(reference, &cameras, place, parameters))
            .collect();
        let (rms_m, excess) = undented(&of_point);
        let of_site = averages(reference, &of_point, excess, parameters);
        Self {
            of_point,
            places,
            of_site,
            rms_m,
        }
    }
}

fn deviation(
    reference: &Reference,
    cameras: &Cameras,
    place: &Point3<f64>,
    parameters: &Parameters,
) -> Option<Deviation> {
    // Far from the surface, or not a number.
    reference.outer.near(&place.cast())?;
    let index = reference.outer.nearest(&place.cast());
    let sample = &reference.outer.samples[index];
    let normal: Vector3<f64> = sample.normal.cast();
    let from_sample = place - sample.point.cast::<f64>();
    let off_m = normal.dot(&from_sample);
    let beside_m2 = from_sample.norm_squared() - off_m * off_m;
    if off_m.abs() > OFF_MAX_M || beside_m2 > BESIDE_MAX_M * BESIDE_MAX_M {
        return None;
    }
    let view = cameras.best_view(place, &normal)?;
    let noise_m = sigma_m(view, parameters);
    Some(Deviation {
        off_m,
        sigma_m: noise_m.hypot(parameters.registration_sigma_m),
        site: reference.sites.of_sample[index],
    })
}

/// RMS of what is not dented, and its ratio to the noise: by the median of |deviation| / sigma, which half of the
/// points may not sway.
fn undented(of_point: &[Option<Deviation>]) -> (f64, f64) {
    /// Of the absolute value of a normal variable.
    const MEDIAN: f64 = 0.674_489_75;
    const INLIER: f64 = 3.0;
    let mut ratios: Vec<f64> = of_point
        .iter()
        .flatten()
        .map(|deviation| deviation.off_m.abs() / deviation.sigma_m)
        .collect();
    if ratios.is_empty() {
        return (0.0, 1.0);
    }
    let half = ratios.len() / 2;
    let (_, &mut median, _) = ratios.select_nth_unstable_by(half, f64::total_cmp);
    let excess = (median / MEDIAN).max(1.0);
    let inliers = of_point
        .iter()
        .flatten()
        .filter(|deviation| deviation.off_m.abs() < INLIER * excess * deviation.sigma_m);
    let (sum, count) = inliers.fold((0.0, 0.0), |(sum, count), deviation| {
        (sum + deviation.off_m * deviation.off_m, count + 1.0)
    });
    ((sum / f64::max(count, 1.0)).sqrt(), excess)
}

/// Each site's mean with its neighbours'.
fn averages(
    reference: &Reference,
    of_point: &[Option<Deviation>],
    excess: f64,
    parameters: &Parameters,
) -> Vec<Average> {
    /// By how much an edge of the reference may be misplaced, m.
    const MISPLACED_M: f64 = 0.001_5;
    /// Stereo's errors are alike within a matching window: averaging gains so much less.
    const COMMON: f64 = 0.5;
    let sites = &reference.sites;
    let mut sums = vec![[0.0f64; 3]; sites.list.len()];
    for deviation in of_point.iter().flatten() {
        let sum = &mut sums[deviation.site as usize];
        sum[0] += 1.0;
        sum[1] += deviation.off_m;
        sum[2] += deviation.sigma_m * deviation.sigma_m;
    }
    let average = |site: usize| {
        let mut total = sums[site];
        for beside in sites.beside(site) {
            (0..3).for_each(|k| total[k] += sums[beside][k]);
        }
        let [count, off, variance] = total;
        if count == 0.0 {
            return Average::default();
        }
        let variance = variance / count * excess * excess;
        let bend_m = MISPLACED_M * f64::from(sites.list[site].bend);
        let sigma_sq = variance * (COMMON * COMMON + 1.0 / count)
            + bend_m * bend_m
            + parameters.registration_sigma_m.powi(2);
        Average {
            off_m: off / count,
            sigma_m: sigma_sq.sqrt(),
            count: count as usize,
        }
    };
    (0..sites.list.len()).map(average).collect()
}
