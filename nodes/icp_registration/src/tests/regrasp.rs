//! An object that was put back into the hand another way.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Point3, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;

use super::scene;
use crate::regrasp::{Hidden, Regrasp, RegraspError, regrasp};

const BOTTOM_M: f64 = 0.1277;
const HEIGHT_M: f64 = 0.11;
const HIDDEN: Hidden = Hidden {
    below_m: BOTTOM_M,
    fingertips_m: BOTTOM_M + 0.03,
    finger_width_m: 0.042,
};

/// A surface about the object's middle: of each height (0 to 1) and angle, the distance from the axis, m.
type Shape = fn(f64, f64) -> f64;

/// Narrow above, wide below.
fn cone(share: f64, _: f64) -> f64 {
    0.045 - 0.02 * share
}

/// A box with a waist, and with a ridge up one of its sides, which tells each way of holding it from the others.
fn ridged_box(share: f64, angle: f64) -> f64 {
    let waist = 0.65 + 0.35 * (2.0 * share - 1.0).powi(2);
    let square = waist * 0.032 / angle.cos().abs().max(0.79 * angle.sin().abs());
    let near = (angle - 1.1).abs() < 0.25 && share < 0.6;
    square + if near { 0.015 } else { 0.0 }
}

/// As wide above as below, with a waist.
fn spool(share: f64, _: f64) -> f64 {
    0.025 + 0.017 * (2.0 * (share - 0.5).abs()).powi(2)
}

/// What all views together show of an object held so: neither what the fingers cover nor its underside.
fn seen(
    random: &mut Pcg64Mcg,
    shape: Shape,
    hand_from_object: &Isometry3<f64>,
) -> Vec<Point3<f32>> {
    let noise = Normal::new(0.0, 0.0004).unwrap();
    let mut points = Vec::new();
    for _ in 0..9000 {
        let (mut share, angle) = (
            random.random_range(-0.2..1.2_f64),
            random.random_range(0.0..TAU),
        );
        let mut radius = 1.0;
        if !(0.0..=1.0).contains(&share) {
            // A lid, evenly covered.
            share = share.round().clamp(0.0, 1.0);
            radius = random.random::<f64>().sqrt();
        }
        let radius_m = radius * shape(share, angle) + noise.sample(random);
        let height_m = (share - 0.5) * HEIGHT_M + noise.sample(random);
        let place = Point3::new(radius_m * angle.cos(), radius_m * angle.sin(), height_m);
        let point = hand_from_object * place;
        let held = point.x.abs() < 0.021 && point.z < BOTTOM_M + 0.03 && radius == 1.0;
        if !held && point.z > BOTTOM_M + 0.002 {
            points.push(point.cast());
        }
    }
    points
}

/// Somehow between the fingers.
fn hand_from_object(random: &mut Pcg64Mcg, upside_down: bool) -> Isometry3<f64> {
    let mut within = |most: f64| random.random_range(-most..most);
    let shift = Vector3::new(
        within(0.006),
        within(0.001),
        BOTTOM_M + HEIGHT_M / 2.0 + within(0.004),
    );
    let lean = Isometry3::rotation(Vector3::new(within(0.05), within(0.05), 0.0));
    let turn = Isometry3::rotation(Vector3::z() * within(PI));
    let over = Isometry3::rotation(Vector3::x() * if upside_down { PI } else { 0.0 });
    Isometry3::from_parts(shift.into(), Default::default()) * lean * turn * over
}

#[test]
fn a_second_grasp_is_laid_onto_the_first_upside_down_and_upright() {
    for seed in 31..35 {
        let random = &mut scene::random(seed);
        for upside_down in [true, false] {
            let first_pose = hand_from_object(random, false);
            let second_pose = hand_from_object(random, upside_down);
            let first = seen(random, ridged_box, &first_pose);
            let second = seen(random, ridged_box, &second_pose);
            let found = regrasp(&first, &second, &HIDDEN).unwrap();
            assert_eq!(found.upside_down, upside_down, "{found:?}");
            let truth = first_pose * second_pose.inverse();
            let off_m = scene::distance_m(&found.first_from_second, &truth, &second);
            assert!(off_m < 0.002, "{off_m} m; {found:?}");
        }
    }
}

#[test]
fn how_a_round_object_was_turned_does_not_matter() {
    for (seed, upside_down) in [(41, true), (42, false)] {
        let random = &mut scene::random(seed);
        let first_pose = hand_from_object(random, false);
        let first = seen(random, cone, &first_pose);
        let second_pose = hand_from_object(random, upside_down);
        let second = seen(random, cone, &second_pose);
        let found = regrasp(&first, &second, &HIDDEN).unwrap();
        assert_eq!(found.upside_down, upside_down, "{found:?}");
        let off_m = axis_off_m(&found, &first_pose, &second_pose);
        assert!(off_m < 0.002, "{off_m} m; {found:?}");
    }
}

#[test]
fn what_looks_the_same_both_ways_was_turned_over_as_asked() {
    let random = &mut scene::random(51);
    let poses = [false, true].map(|over| hand_from_object(random, over));
    let [first, second] = poses.map(|pose| seen(random, spool, &pose));
    let found = regrasp(&first, &second, &HIDDEN).unwrap();
    assert!(found.upside_down, "{found:?}");
    let off_m = axis_off_m(&found, &poses[0], &poses[1]);
    assert!(off_m < 0.002, "{off_m} m; {found:?}");
}

/// How far the upper end of the object's axis is off, whatever the turn about it, m.
fn axis_off_m(found: &Regrasp, first: &Isometry3<f64>, second: &Isometry3<f64>) -> f64 {
    let between = first.inverse() * found.first_from_second * second;
    let end = Point3::new(0.0, 0.0, HEIGHT_M / 2.0);
    (between * end - end).norm()
}

#[test]
fn another_object_is_refused_with_the_figures() {
    let random = &mut scene::random(61);
    let poses = [false, true].map(|over| hand_from_object(random, over));
    let first = seen(random, ridged_box, &poses[0]);
    let second = seen(random, cone, &poses[1]);
    let error = regrasp(&first, &second, &HIDDEN).unwrap_err();
    assert!(matches!(error, RegraspError::Disagree(_)), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("same object") && text.contains(" mm"),
        "{text}"
    );
    let error = regrasp(&first, &[], &HIDDEN).unwrap_err();
    assert!(matches!(error, RegraspError::Registration(_)), "{error}");
}
