//! What must hold whatever the object.

use nalgebra::{Isometry3, Point3, Vector3};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::scene::{self, about_object, distance_m, hand_from_camera};
use crate::{Metric, Parameters, Registrar};

const NOISE_M: f64 = 0.0006;

/// Views of a block at wrist angles of 0 and 0.6 rad, in the camera's frame, m.
fn two_views(seed: u64) -> (Pcg64Mcg, Vec<Point3<f32>>, Vec<Point3<f32>>) {
    let mut random = scene::random(seed);
    let block = scene::block(&mut random, 15_000);
    let mut view = |angle_rad| {
        let pose = hand_from_camera(angle_rad);
        scene::view(&mut random, &block, &pose, NOISE_M)
    };
    let (first, second) = (view(0.0), view(0.6));
    (random, first, second)
}

/// From wherever a start within the bounds is off, the view comes to lie where it belongs.
#[test]
fn perturbed_starts_end_in_one_place() {
    let (mut random, first, view) = two_views(51);
    let truth = hand_from_camera(0.6);
    for metric in [Metric::Plane, Metric::Point] {
        for _ in 0..12 {
            let mut within =
                |limit: f64| Vector3::from_fn(|_, _| random.random_range(-limit..limit));
            let error = about_object(within(0.005), within(0.035));
            let parameters = Parameters {
                metric,
                ..Parameters::default()
            };
            let mut registrar = Registrar::new(parameters).unwrap();
            registrar
                .add_view(&first, Some(hand_from_camera(0.0)))
                .unwrap();
            let evidence = registrar.add_view(&view, Some(error * truth)).unwrap();
            let off_m = distance_m(&evidence.transform, &truth, &view);
            assert!(
                evidence.accepted && off_m < 0.003,
                "{metric:?}: {off_m} m: {evidence:?}"
            );
        }
    }
}

/// What one motion does to the view, its inverse undoes.
#[test]
fn inverse_errors_are_corrected_by_inverse_motions() {
    let (_, first, view) = two_views(52);
    let truth = hand_from_camera(0.6);
    let error = about_object(
        Vector3::new(0.003, -0.002, 0.002),
        Vector3::new(0.02, 0.01, -0.03),
    );
    let corrected = |error: &Isometry3<f64>| {
        let mut registrar = Registrar::new(Parameters::default()).unwrap();
        registrar
            .add_view(&first, Some(hand_from_camera(0.0)))
            .unwrap();
        let evidence = registrar.add_view(&view, Some(error * truth)).unwrap();
        evidence.transform * (error * truth).inverse()
    };
    let both = corrected(&error) * corrected(&error.inverse());
    let middle = Point3::new(0.0, 0.0, 0.1877);
    assert!(
        (both * middle - middle).norm() < 0.0005 && both.rotation.angle() < 0.005,
        "{both}"
    );
}

/// Whatever the order of the views, the merged cloud lies as near to the object.
#[test]
fn the_order_of_views_does_not_matter_beyond_noise() {
    let mut random = scene::random(53);
    let block = scene::block(&mut random, 15_000);
    let views: Vec<_> = [-0.6, 0.0, 0.6, 1.2]
        .map(|wrist_rad| {
            let truth = hand_from_camera(wrist_rad);
            let error = about_object(
                Vector3::new(0.001, 0.001, 0.0),
                Vector3::new(0.0, 0.01, 0.01),
            );
            (
                scene::view(&mut random, &block, &truth, NOISE_M),
                truth,
                error * truth,
            )
        })
        .into();
    let mut off_m = Vec::new();
    for order in [[0, 1, 2, 3], [1, 2, 0, 3], [2, 3, 1, 0], [3, 2, 1, 0]] {
        let mut registrar = Registrar::new(Parameters::default()).unwrap();
        let mut first = None;
        let mut farthest_m: f64 = 0.0;
        for (points, truth, believed) in order.map(|index| &views[index]) {
            let evidence = registrar.add_view(points, Some(*believed)).unwrap();
            assert!(evidence.accepted, "{evidence:?}");
            // The first view keeps its place, and the others are where it is off to.
            let frame = *first.get_or_insert(evidence.transform * truth.inverse());
            farthest_m = farthest_m.max(distance_m(&evidence.transform, &(frame * truth), points));
        }
        off_m.push(farthest_m);
    }
    println!("farthest off in each order: {off_m:?} m");
    assert!(off_m.iter().all(|off_m| *off_m < 0.0025));
}

#[test]
fn the_same_views_give_the_same_answer_to_the_last_bit() {
    let mut random = scene::random(54);
    let block = scene::block(&mut random, 8_000);
    let views: Vec<_> = [0.0, 0.6, 1.2]
        .map(|wrist_rad| {
            let pose = hand_from_camera(wrist_rad);
            (scene::view(&mut random, &block, &pose, NOISE_M), pose)
        })
        .into();
    let run = || {
        let mut registrar = Registrar::new(Parameters::default()).unwrap();
        let evidence: Vec<_> = views
            .iter()
            .map(|(points, pose)| registrar.add_view(points, Some(*pose)).unwrap())
            .collect();
        (evidence, registrar.cloud(), registrar.coverage_rad())
    };
    let (first, second) = (run(), run());
    assert_eq!(first, second);
    let seen = first.2.to_degrees();
    assert!(
        (200.0..=290.0).contains(&seen),
        "two sides and the turn: {seen} degrees"
    );
}
