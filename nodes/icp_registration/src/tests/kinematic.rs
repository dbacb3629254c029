use nalgebra::{Isometry3, Vector3};
use rand_pcg::Pcg64Mcg;

use super::scene::{self, Spot, about_object, distance_m, hand_from_camera};
use crate::{Parameters, Registrar, StopReason, ViewEvidence};

const NOISE_M: f64 = 0.0006;

/// Three views of an object; the kinematics are wrong by `error` for the last.
fn scan(
    random: &mut Pcg64Mcg,
    spots: &[Spot],
    error: &Isometry3<f64>,
    parameters: Parameters,
) -> (Registrar, ViewEvidence, f64) {
    let mut registrar = Registrar::new(parameters).unwrap();
    for wrist_rad in [-0.6, 0.0] {
        let pose = hand_from_camera(wrist_rad);
        registrar
            .add_view(&scene::view(random, spots, &pose, NOISE_M), Some(pose))
            .unwrap();
    }
    let truth = hand_from_camera(0.6);
    let view = scene::view(random, spots, &truth, NOISE_M);
    let points_before = registrar.cloud().len();
    let evidence = registrar.add_view(&view, Some(error * truth)).unwrap();
    let off_m = distance_m(&evidence.transform, &truth, &view);
    assert_eq!(
        registrar.cloud().len() > points_before,
        evidence.accepted,
        "a view is in the cloud unless it was refused"
    );
    assert_eq!(registrar.count().refused, u32::from(!evidence.accepted));
    println!("off by {:.2} mm: {evidence:?}", off_m * 1e3);
    (registrar, evidence, off_m)
}

#[test]
fn an_error_of_the_kinematics_is_corrected() {
    let mut random = scene::random(31);
    let block = scene::block(&mut random, 15_000);
    let error = about_object(
        Vector3::new(0.004, -0.003, 0.002),
        Vector3::new(0.02, 0.03, -0.04),
    );
    let (registrar, evidence, off_m) = scan(&mut random, &block, &error, Parameters::default());
    assert!(registrar.in_hand_frame());
    assert!(evidence.accepted && evidence.stop_reason == StopReason::Converged);
    assert_eq!(evidence.degenerate_directions, 0);
    assert!(off_m < 0.0015, "{off_m} m");
    // From where the two views before, with their noise, said that the mount was off.
    assert!(
        (evidence.correction_m - 0.0054).abs() < 0.003
            && (evidence.correction_rad - 0.054).abs() < 0.01
    );
}

#[test]
fn correct_kinematics_are_left_nearly_alone() {
    let mut random = scene::random(32);
    for spots in [
        scene::block(&mut random, 15_000),
        scene::tube(&mut random, 0.033, 15_000),
    ] {
        let (_, evidence, off_m) = scan(
            &mut random,
            &spots,
            &Isometry3::identity(),
            Parameters::default(),
        );
        assert!(evidence.accepted && off_m < 0.001, "{off_m} m");
    }
}

#[test]
fn a_tube_keeps_how_it_was_turned_and_is_corrected_otherwise() {
    let mut random = scene::random(33);
    let tube = scene::tube(&mut random, 0.033, 15_000);
    let error = about_object(
        Vector3::new(0.004, -0.003, 0.0),
        Vector3::new(0.02, -0.02, 0.08),
    );
    let (_, evidence, _) = scan(&mut random, &tube, &error, Parameters::default());
    assert!(evidence.accepted);
    assert!(evidence.degenerate_directions >= 1);
    let remaining = evidence.transform * hand_from_camera(0.6).inverse();
    let turn = remaining.rotation.scaled_axis();
    println!("turned by {turn:?} after correction");
    assert!(
        (turn.z - 0.08).abs() < 0.015,
        "the turn about the axis was touched: {turn:?}"
    );
    assert!(
        turn.xy().norm() < 0.01,
        "the tilt was not corrected: {turn:?}"
    );
    let axis = remaining * nalgebra::Point3::new(0.0, 0.0, 0.1877);
    assert!(
        axis.xy().coords.norm() < 0.001,
        "the axis is off by {axis:?}"
    );
}

#[test]
fn a_correction_beyond_its_bounds_is_refused_and_the_start_is_kept() {
    let mut random = scene::random(34);
    let block = scene::block(&mut random, 15_000);
    let mut refused = |error: &Isometry3<f64>, tight, reason: &str| {
        let (_, evidence, _) = scan(&mut random, &block, error, tight);
        let is_refused = !evidence.accepted && evidence.reason.contains(reason);
        assert!(is_refused, "{}", evidence.reason);
        evidence
    };
    let error = about_object(Vector3::new(0.006, 0.004, 0.0), Vector3::zeros());
    let tight = Parameters {
        max_correction_m: 0.004,
        ..Parameters::default()
    };
    let evidence = refused(&error, tight, "max_correction_m allows 4.0 mm");
    // But for what the two views before, with their noise, said of the mount.
    let off = evidence.transform * (error * hand_from_camera(0.6)).inverse();
    let place = nalgebra::Point3::new(0.0, 0.0, 0.1877);
    assert!((off * place - place).norm() < 0.001 && off.rotation.angle() < 0.01);
    assert_eq!(evidence.stop_reason, StopReason::Refused);

    let error = about_object(Vector3::zeros(), Vector3::new(0.0, 0.0, 0.06));
    let tight = Parameters {
        max_correction_rad: 0.03,
        ..Parameters::default()
    };
    refused(&error, tight, "max_correction_rad allows 1.7°");
}

/// Wrong by 7 mm and 1.4° in the camera's frame, as a mount measured by hand may be, each view is farther from the first by
/// kinematics, and soon farther than any correction may go.
#[test]
fn an_error_of_the_mount_is_carried_from_view_to_view() {
    let mut random = scene::random(36);
    let block = scene::block(&mut random, 15_000);
    let mount = Isometry3::new(
        Vector3::new(0.006, 0.0, 0.004),
        Vector3::new(0.0, 0.025, 0.0),
    );
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    let (mut farthest_m, mut remaining) = (0.0, 1.0);
    let first_from_actual = |pose: &Isometry3<f64>| {
        hand_from_camera(-1.2) * mount * hand_from_camera(-1.2).inverse() * pose
    };
    for wrist_rad in [-1.2, -0.6, 0.0, 0.6, 1.2] {
        let truth = hand_from_camera(wrist_rad);
        let view = scene::view(&mut random, &block, &truth, NOISE_M);
        let evidence = registrar.add_view(&view, Some(truth * mount)).unwrap();
        let off_m = distance_m(&evidence.transform, &first_from_actual(&truth), &view);
        let kinematics_m = distance_m(&(truth * mount), &first_from_actual(&truth), &view);
        println!(
            "{wrist_rad}: off by {:.2} mm, kinematics by {:.1} mm",
            1e3 * off_m,
            1e3 * kinematics_m
        );
        assert!(evidence.accepted, "{evidence:?}");
        remaining = off_m / kinematics_m;
        farthest_m = kinematics_m;
    }
    assert!(farthest_m > 1.3 * Parameters::default().max_correction_m);
    assert!(remaining < 0.4, "{remaining}");
}

#[test]
fn what_does_not_turn_with_the_wrist_is_not_matched() {
    let mut random = scene::random(35);
    let block = scene::block(&mut random, 15_000);
    let error = about_object(
        Vector3::new(0.004, -0.003, 0.002),
        Vector3::new(0.02, 0.03, -0.04),
    );
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    // A second block, below the hand, stands still while the wrist turns.
    let below: Vec<Spot> = block
        .iter()
        .map(|(place, normal)| (place - Vector3::z() * 0.3, *normal))
        .collect();
    let still = hand_from_camera(0.0);
    for wrist_rad in [0.0, 0.6] {
        let truth = hand_from_camera(wrist_rad);
        let mut view = scene::view(&mut random, &block, &truth, NOISE_M);
        view.extend(scene::view(&mut random, &below, &still, NOISE_M));
        let pose = if wrist_rad == 0.0 {
            truth
        } else {
            error * truth
        };
        let evidence = registrar.add_view(&view, Some(pose)).unwrap();
        assert!(
            distance_m(&evidence.transform, &truth, &view[..1000]) < 0.0015,
            "{evidence:?}"
        );
    }
}
