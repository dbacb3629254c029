//! How deep the bottom of a dent is.
//!
//! The largest of all deviations is that of the worst stray. Here a cone is fitted to what lies around the deepest place:
//! `depth = bottom - slope * distance`, with Geman and McClure's weights, so that strays and the far wall of a cup count
//! for nothing. Its tip is the depth.

use nalgebra::{Point3, Vector2};

use crate::field::{Average, Field};
use crate::reference::tangents;
use crate::sites::Site;

/// A dent's bottom.
pub(crate) struct Bottom {
    pub depth_m: f64,
    /// Standard deviation of it.
    pub sigma_m: f64,
}

/// The cone reaches so far.
const REACH_M: f64 = 0.008;
/// The tip is looked for within this distance.
const TIP_REACH_M: f64 = 0.007;
/// Points shallower than this share of the depth are beside the dent, or on another wall.
const INSIDE_SHARE: f64 = 0.3;
/// Radius within which a stereo camera's matching window and the cloud's voxels make a tip blunt: the cone's own tip lies
/// so much farther down its slope.
const BLUNT_M: f64 = 0.002_4;
const ROUNDS: usize = 4;
const POINTS_MIN: usize = 6;

/// A point of the cloud around the deepest site.
struct Around {
    beside: Vector2<f64>,
    depth_m: f64,
    sigma_m: f64,
}

/// Of the dent that is deepest around a site.
pub(crate) fn bottom(site: &Site, average: &Average, field: &Field) -> Bottom {
    let mean_m = -average.off_m;
    let around = around(site, INSIDE_SHARE * mean_m, field);
    let tip = tip(&around, mean_m);
    let near: Vec<(f64, &Around)> = around
        .iter()
        .map(|point| ((point.beside - tip).norm(), point))
        .filter(|(distance_m, _)| *distance_m < REACH_M)
        .collect();
    let depth_m = if near.len() < POINTS_MIN {
        mean_m
    } else {
        cone(&near).max(mean_m)
    };
    Bottom {
        depth_m,
        sigma_m: average.sigma_m,
    }
}

fn around(site: &Site, depth_min_m: f64, field: &Field) -> Vec<Around> {
    let [across, up] = tangents(&site.normal).map(|direction| direction.into_inner().cast::<f64>());
    let centre: Point3<f64> = site.point.cast();
    let mut around = Vec::new();
    for (deviation, place) in field.of_point.iter().zip(&field.places) {
        let Some(deviation) = deviation else { continue };
        let beside = place - centre;
        let beside = Vector2::new(across.dot(&beside), up.dot(&beside));
        if -deviation.off_m > depth_min_m && beside.norm() < TIP_REACH_M + REACH_M {
            around.push(Around {
                beside,
                depth_m: -deviation.off_m,
                sigma_m: deviation.sigma_m,
            });
        }
    }
    around
}

/// Where it is deepest: the mean of the deep points, moved there a few times.
fn tip(around: &[Around], mean_m: f64) -> Vector2<f64> {
    let mut tip = Vector2::zeros();
    for _ in 0..3 {
        let (mut sum, mut weights) = (Vector2::zeros(), 0.0);
        for point in around {
            if (point.beside - tip).norm() < TIP_REACH_M {
                let weight = (point.depth_m - 0.7 * mean_m).max(0.0).powi(2);
                sum += point.beside * weight;
                weights += weight;
            }
        }
        if weights > 0.0 {
            tip = sum / weights;
        }
    }
    tip
}

/// Depth of the tip of the cone through points at these distances from it.
fn cone(points: &[(f64, &Around)]) -> f64 {
    let mut weights: Vec<f64> = points.iter().map(|(_, p)| p.sigma_m.powi(-2)).collect();
    let mut tip_m = 0.0;
    for _ in 0..ROUNDS {
        let total: f64 = weights.iter().sum();
        let mean = |value: fn(&(f64, &Around)) -> f64| {
            let sum: f64 = points
                .iter()
                .zip(&weights)
                .map(|(point, w)| w * value(point))
                .sum();
            sum / total
        };
        let (distance_m, depth_m) = (mean(|p| p.0), mean(|p| p.1.depth_m));
        let (mut square, mut product) = (0.0, 0.0);
        for ((at_m, point), weight) in points.iter().zip(&weights) {
            square += weight * (at_m - distance_m).powi(2);
            product += weight * (at_m - distance_m) * (point.depth_m - depth_m);
        }
        let slope = if square > 0.0 {
            (-product / square).max(0.0)
        } else {
            0.0
        };
        let foot_m = depth_m + slope * distance_m;
        tip_m = foot_m + slope * BLUNT_M;
        for ((at_m, point), weight) in points.iter().zip(&mut weights) {
            let off = (point.depth_m - (foot_m - slope * at_m)) / (2.0 * point.sigma_m);
            *weight = (point.sigma_m * (1.0 + off * off)).powi(-2);
        }
    }
    tip_m
}
