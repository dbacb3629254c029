//! Where a fit begins: upright or upside down, about the hand's axis or behind what the cameras see.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use crate::observation::Observation;
use crate::placement::{Placement, unscaled, upright};
use crate::reference::Reference;

/// Turns about the axis that are tried where they differ.
const TURNS: usize = 12;
/// Share of the points that may lie above what is taken for the top: strays.
const ABOVE_TOP: f64 = 0.004;

/// Placements to begin with.
pub(crate) fn starts(reference: &Reference, seen: &Observation<'_>) -> Vec<Placement> {
    let level = upright(&seen.up);
    let points: Vec<Point3<f64>> = seen
        .points
        .iter()
        .map(|p| level * p.cast::<f64>())
        .collect();
    let mut heights_m: Vec<f64> = points.iter().map(|point| point.z).collect();
    let above = (ABOVE_TOP * heights_m.len() as f64) as usize;
    if above >= heights_m.len() {
        return Vec::new();
    }
    let place = heights_m.len() - 1 - above;
    let (_, &mut top_m, _) = heights_m.select_nth_unstable_by(place, f64::total_cmp);
    let mut axes = behind(reference, seen, &points, &level);
    if seen.in_hand_frame {
        axes.push(Vector3::zeros());
    }
    let over = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
    let turns = if reference.is_of_revolution { 1 } else { TURNS };
    let height_m = f64::from(reference.height_m);
    let mut starts = Vec::new();
    for axis in axes {
        let bottom = Vector3::new(axis.x, axis.y, top_m - height_m);
        let stands = Isometry3::from_parts(Translation3::from(-bottom), UnitQuaternion::identity());
        let hangs = Translation3::new(0.0, 0.0, height_m) * over;
        for turn in 0..turns {
            let angle_rad = std::f64::consts::TAU * turn as f64 / turns as f64;
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad);
            for way in [Isometry3::identity(), hangs] {
                starts.push(unscaled(turned * way * stands * level));
            }
        }
    }
    starts
}

/// Where the axis is if what was seen is the side that faces the cameras; all around where nobody knows the cameras.
fn behind(
    reference: &Reference,
    seen: &Observation<'_>,
    points: &[Point3<f64>],
    level: &UnitQuaternion<f64>,
) -> Vec<Vector3<f64>> {
    /// Mean distance of the visible half of a cylinder from its axis, as a share of its radius: 2/pi.
    const SHARE: f64 = std::f64::consts::FRAC_2_PI;
    const DIRECTIONS: usize = 6;
    let count = points.len() as f64;
    let mut sum = Vector3::zeros();
    points.iter().for_each(|point| sum += point.coords);
    let middle = sum / count;
    let reach_m = SHARE * f64::from(reference.radius_m);
    if seen.viewpoints.is_empty() {
        let towards = |step: usize| {
            let (sin, cos) = (step as f64 / DIRECTIONS as f64 * std::f64::consts::TAU).sin_cos();
            middle + Vector3::new(cos, sin, 0.0) * reach_m
        };
        return (0..DIRECTIONS).map(towards).chain([middle]).collect();
    }
    let mut from_cameras = Vector3::zeros();
    for viewpoint in seen.viewpoints {
        let mut away = middle - (level * viewpoint).coords;
        away.z = 0.0;
        from_cameras += away.try_normalize(1e-9).unwrap_or_default();
    }
    vec![middle + from_cameras / seen.viewpoints.len() as f64 * reach_m]
}
