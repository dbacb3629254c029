//! The calibration of the camera mount, on simulated turns of the wrist whose true mount is known.

#![allow(clippy::unwrap_used)]

use camera_mount::calibration::{Calibration, View, calibrate, turn_and_shift};
use nalgebra::{Isometry3, Vector6};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sim_objects::ObjectClass;
use sim_scan::{ScanParameters, Setup, capture};

/// Sweeps of one object with one mount, the arm in as many poses, and the mount's true error.
fn sweeps(class: ObjectClass, poses: usize, seed: u64) -> (Vec<Vec<View>>, Isometry3<f64>) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let parameters = ScanParameters {
        view_count: 8,
        table_share: 0.0,
        wrist_lean_rad: 0.25,
        ..ScanParameters::default()
    };
    let object = sim_scan::dented(class, &parameters, &mut random).unwrap();
    let mut setups: Vec<Setup> = (0..poses)
        .map(|_| Setup::random(&object, &parameters, &mut random))
        .collect();
    let error = setups[0].camera_from_believed_camera;
    for setup in &mut setups {
        setup.camera_from_believed_camera = error;
        setup.threshold = depth_threshold::Parameters::default();
    }
    let sweeps = setups.iter().map(|setup| {
        let views = capture(setup, &mut random).unwrap().into_iter();
        let view = |view: sim_scan::View| View {
            hand_from_camera: view.believed_hand_from_camera,
            points: view.points,
        };
        views.map(view).collect()
    });
    (sweeps.collect(), error.inverse())
}

fn off(calibration: &Calibration, truth: &Isometry3<f64>) -> Vector6<f64> {
    let off = truth.inverse() * calibration.believed_from_actual;
    let (turn, shift) = (off.rotation.scaled_axis(), off.translation.vector);
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}

/// What the sweeps say, held against the truth: off by so many degrees and mm, and by the uncertainty that is claimed.
fn compare(class: ObjectClass, poses: usize, seed: u64) -> (Calibration, Vector6<f64>, f64) {
    let (sweeps, truth) = sweeps(class, poses, seed);
    let found = calibrate(&sweeps).unwrap();
    let off = off(&found, &truth);
    let claimed = found.covariance.try_inverse().unwrap();
    let off_in_sigmas = (off.transpose() * claimed * off)[0].sqrt();
    println!(
        "seed {seed}, {}, {poses} poses: mount off by {:.2}°, {:.1} mm; found to {:.2}°, {:.1} mm, {off_in_sigmas:.1} σ; \
         surfaces {:.2} mm apart, {:.2} mm before; {} motions open",
        class.name(),
        truth.rotation.angle().to_degrees(),
        1e3 * truth.translation.vector.norm(),
        off.fixed_rows::<3>(0).norm().to_degrees(),
        1e3 * off.fixed_rows::<3>(3).norm(),
        1e3 * found.after_m,
        1e3 * found.before_m,
        found.open.len(),
    );
    (found, off, off_in_sigmas)
}

const CLASSES: [ObjectClass; 3] = [
    ObjectClass::MediumCan,
    ObjectClass::SmallCup,
    ObjectClass::TinyBall,
];

#[test]
fn two_poses_of_the_arm_tell_all() {
    for (seed, class) in (40..).zip(CLASSES) {
        let (found, off, off_in_sigmas) = compare(class, 2, seed);
        let (turn, shift) = turn_and_shift(&off);
        assert!(turn.norm().to_degrees() < 0.1 && shift.norm() < 0.0015);
        assert!(
            off_in_sigmas < 4.0,
            "six numbers, more than their uncertainty off"
        );
        assert!(found.open.is_empty());
    }
}

#[test]
fn one_pose_leaves_two_motions_open_and_says_so() {
    for (seed, class) in (50..).zip(CLASSES) {
        let (found, _, off_in_sigmas) = compare(class, 1, seed);
        assert!(off_in_sigmas < 4.0);
        assert_eq!(found.open.len(), 2);
    }
}
