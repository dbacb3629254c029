#![allow(clippy::unwrap_used)]
use super::*;
use crate::observability::Twists;
use crate::tests::scene::hand_from_camera;

const MIDDLE: Point3<f64> = Point3::new(0.0, 0.0, 0.1877);

/// All motions of a hand-sized object known alike.
fn certainty() -> Certainty {
    let corners = [-0.04, 0.04].map(|x| (MIDDLE + Vector3::new(x, x, x)).cast());
    Certainty {
        twists: Twists::around(&corners).unwrap(),
        information: Matrix6::identity() / 3.0,
    }
}

#[test]
fn the_next_view_starts_where_the_mounts_error_puts_it() {
    let error = Isometry3::new(
        Vector3::new(0.006, -0.005, 0.004),
        Vector3::new(0.02, -0.015, 0.02),
    );
    // The first view keeps its place, so that all is seen through its error.
    let registered = |wrist_rad: f64| {
        hand_from_camera(0.0)
            * error.inverse()
            * hand_from_camera(0.0).inverse()
            * hand_from_camera(wrist_rad)
            * error
    };
    let off_m = |mount: &MountError, wrist_rad: f64| {
        let place = registered(wrist_rad).inverse() * MIDDLE;
        (mount.start(&hand_from_camera(wrist_rad)) * place - MIDDLE).norm()
    };
    let mut mount = MountError::default();
    mount.begin(&hand_from_camera(0.0));
    let before_m = off_m(&mount, 1.2);
    mount.learn(&hand_from_camera(0.6), &registered(0.6), certainty());
    let after_m = off_m(&mount, 1.2);
    println!(
        "off by {:.2} mm, {:.2} mm without",
        1e3 * after_m,
        1e3 * before_m
    );
    assert!(before_m > 0.008 && after_m < 0.15 * before_m);
}

#[test]
fn what_is_not_determined_says_nothing() {
    let mut mount = MountError::default();
    mount.begin(&hand_from_camera(0.0));
    let none = Certainty {
        information: Matrix6::zeros(),
        ..certainty()
    };
    let elsewhere = Isometry3::translation(0.01, 0.0, 0.0) * hand_from_camera(0.6);
    mount.learn(&hand_from_camera(0.6), &elsewhere, none);
    let pose = hand_from_camera(1.2);
    assert!(
        (mount.start(&pose).inverse() * pose)
            .translation
            .vector
            .norm()
            < 1e-9
    );
}
