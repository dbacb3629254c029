#![allow(clippy::unwrap_used)]

use nalgebra::{Translation3, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

/// The sides of an upright block on the hand, seen by a camera 0.4 m in front of it.
fn view(wrist_rad: f64, mount_error: &Isometry3<f64>, half_m: [f64; 3]) -> View {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -wrist_rad);
    let eye = Point3::new(0.39, 0.0, 0.3877);
    let middle = Point3::new(0.0, 0.0, 0.1877);
    let camera = Isometry3::face_towards(&eye, &middle, &-Vector3::z());
    let hand_from_camera = Isometry3::from_parts(Translation3::identity(), turned) * camera;
    let eye = Point3::from(hand_from_camera.translation.vector);
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut points = Vec::new();
    while points.len() < 4000 {
        let axis = random.random_range(0..3);
        let side = if random.random() { 1.0 } else { -1.0 };
        let mut place =
            Vector3::from_fn(|axis, _| random.random_range(-half_m[axis]..half_m[axis]));
        place[axis] = side * half_m[axis];
        let place = middle + place;
        if (eye - place)[axis] * side > 0.0 {
            points.push((hand_from_camera.inverse() * place).cast());
        }
    }
    View {
        // What kinematics believe is off by the mount's error.
        hand_from_camera: hand_from_camera * mount_error.inverse(),
        points,
    }
}

const BLOCK_M: [f64; 3] = [0.03, 0.045, 0.06];

fn sweep(mount_error: &Isometry3<f64>) -> Vec<View> {
    let angles = [-1.2, -0.6, 0.0, 0.6, 1.2];
    angles.map(|angle| view(angle, mount_error, BLOCK_M)).into()
}

#[test]
fn the_axis_is_found_in_the_camera_and_what_lies_along_it_is_open() {
    let error = Isometry3::new(
        Vector3::new(0.006, -0.005, 0.004),
        Vector3::new(0.02, -0.015, 0.02),
    );
    let found = calibrate(&[sweep(&error)]).unwrap();
    println!(
        "{} m apart before, {} m after",
        found.before_m, found.after_m
    );
    assert!(found.before_m > 0.001 && found.after_m < 0.0003);
    // The wrist's axis: a point on it and its direction, where the camera is and where it was found to be.
    let (place, axis) = (Point3::new(0.0, 0.0, 0.1877), Vector3::z());
    let camera_from_hand = (sweep(&error)[2].hand_from_camera * error).inverse();
    let found_from_hand =
        (sweep(&error)[2].hand_from_camera * found.believed_from_actual).inverse();
    let (there, here) = (found_from_hand * axis, camera_from_hand * axis);
    assert!(there.angle(&here) < 2e-3, "{} rad", there.angle(&here));
    let aside = (found_from_hand * place - camera_from_hand * place).cross(&here);
    assert!(aside.norm() < 3e-4, "{} m", aside.norm());

    assert_eq!(found.open.len(), 2);
    let along = |motion: &Vector6<f64>| {
        let (turn, shift) = turn_and_shift(motion);
        turn.normalize()
            .dot(&here)
            .abs()
            .max(shift.normalize().dot(&here).abs())
    };
    assert!(
        found.open.iter().all(|motion| along(motion) > 0.95),
        "{:?}",
        found.open
    );
}

#[test]
fn another_frame_tells_the_same() {
    let error = Isometry3::new(Vector3::new(0.005, 0.0, 0.0), Vector3::new(0.0, 0.01, 0.0));
    let found = calibrate(&[sweep(&error)]).unwrap();
    let b_from_camera = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6));
    let back = found
        .seen_from(&b_from_camera)
        .seen_from(&b_from_camera.inverse());
    assert!((back.covariance - found.covariance).norm() < 1e-12);
    let off = back.believed_from_actual.inverse() * found.believed_from_actual;
    assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-9);
}

#[test]
fn what_is_no_sweep_is_refused_by_name() {
    let error = Isometry3::identity();
    let one = vec![view(0.0, &error, BLOCK_M)];
    assert_eq!(
        calibrate(&[one]).unwrap_err(),
        CalibrationError::TooFewViews { count: 1 }
    );
    let mut empty = sweep(&error);
    empty[3].points.clear();
    let refused = calibrate(&[sweep(&error), empty]).unwrap_err();
    assert!(matches!(
        refused,
        CalibrationError::TooFewPoints {
            number: 9,
            count: 0,
            ..
        }
    ));

    let mut apart = [0.0, 0.6].map(|angle| view(angle, &error, BLOCK_M));
    apart[1].hand_from_camera = Translation3::new(0.0, 0.0, 0.2) * apart[1].hand_from_camera;
    let refused = calibrate(&[apart.into()]).unwrap_err();
    assert!(
        matches!(refused, CalibrationError::NothingInCommon { .. }),
        "{refused}"
    );
}

#[test]
fn an_object_that_slips_is_noticed() {
    let angles = [
        (-1.2, 0.0),
        (-0.6, 0.012),
        (0.0, -0.012),
        (0.6, 0.012),
        (1.2, -0.012),
    ];
    let slipping = angles.map(|(angle, slip_m)| {
        let mut view = view(angle, &Isometry3::identity(), BLOCK_M);
        view.hand_from_camera = Translation3::new(0.0, slip_m, slip_m) * view.hand_from_camera;
        view
    });
    let refused = calibrate(&[slipping.into()]).unwrap_err();
    assert!(
        matches!(refused, CalibrationError::Disagreement { .. }),
        "{refused}"
    );
}

/// Turn of the wrist (rad) and its rate (rad/s) at each view of a sweep: from the middle to the beginning, and on to the end.
const TURNING: [(f64, f64); 12] = [
    (0.0, -0.6),
    (-0.4, -1.15),
    (-0.8, -1.15),
    (-1.2, -1.15),
    (-1.6, -0.6),
    (0.2, 1.15),
    (0.5, 1.15),
    (0.8, 1.15),
    (1.1, 1.15),
    (1.4, 1.15),
    (1.7, 1.15),
    (2.0, 0.6),
];

/// How far the wrist's axis is from where it is found, rad and m, by views of these numbers whose stamps are so late, s.
fn axis_off(chosen: &[usize], late_s: f64) -> (f64, f64) {
    let error = Isometry3::new(
        Vector3::new(0.006, -0.005, 0.004),
        Vector3::new(0.02, -0.015, 0.02),
    );
    let late = |number: &usize| {
        let (wrist_rad, rate_rad_s) = TURNING[*number];
        let mut view = view(wrist_rad, &error, BLOCK_M);
        view.hand_from_camera =
            Isometry3::rotation(Vector3::z() * -(rate_rad_s * late_s)) * view.hand_from_camera;
        view
    };
    let views: Vec<View> = chosen.iter().map(late).collect();
    let found = calibrate(&[views]).unwrap();
    let (place, axis) = (Point3::new(0.0, 0.0, 0.1877), Vector3::z());
    let believed = view(0.0, &error, BLOCK_M).hand_from_camera;
    let camera_from_hand = (believed * error).inverse();
    let found_from_hand = (believed * found.believed_from_actual).inverse();
    let (there, here) = (found_from_hand * axis, camera_from_hand * axis);
    let aside = (found_from_hand * place - camera_from_hand * place).cross(&here);
    (there.angle(&here), aside.norm())
}

#[test]
fn stamps_of_another_clock_hardly_move_the_mount_whichever_views_are_used() {
    let rates_rad_s = TURNING.map(|(_, rate_rad_s)| rate_rad_s);
    let steady = crate::steady_views(&rates_rad_s, 6);
    let of_all_rates = [0, 2, 4, 6, 8, 11];
    for late_s in [0.015, 0.05] {
        for chosen in [&steady[..], &of_all_rates] {
            let (turn_rad, shift_m) = axis_off(chosen, late_s);
            println!("{late_s} s, views {chosen:?}: {turn_rad} rad, {shift_m} m");
            assert!(turn_rad < 1e-3 && shift_m < 3e-4);
        }
    }
}
