use nalgebra::{Isometry3, Point3, Vector3};

use super::scene::{self, about_object, distance_m};
use crate::{Parameters, Registrar, StopReason, register};

/// A block seen whole, and moved.
fn block_and_moved(seed: u64, motion: &Isometry3<f64>) -> (Vec<Point3<f32>>, Vec<Point3<f32>>) {
    let mut random = scene::random(seed);
    let mut points = |motion: &Isometry3<f64>| {
        scene::block(&mut random, 9000)
            .iter()
            .map(|(place, _)| (motion * place).cast())
            .collect()
    };
    (points(&Isometry3::identity()), points(motion))
}

#[test]
fn a_known_motion_is_recovered_and_its_inverse_too() {
    let motion = about_object(
        Vector3::new(0.004, -0.003, 0.005),
        Vector3::new(0.05, -0.04, 0.06),
    );
    let (at_rest, moved) = block_and_moved(21, &motion);
    let find = |from: &[Point3<f32>], to: &[Point3<f32>]| {
        let (_, evidence) = register(Parameters::default(), [(to, None), (from, None)]).unwrap();
        assert_eq!(
            evidence[1].stop_reason,
            StopReason::Converged,
            "{evidence:?}"
        );
        assert!(evidence[1].fitness > 0.99, "{evidence:?}");
        evidence[1].transform
    };
    let (back, forth) = (find(&moved, &at_rest), find(&at_rest, &moved));
    println!(
        "off by {:.6} m and {:.6} m",
        distance_m(&back, &motion.inverse(), &moved),
        distance_m(&forth, &motion, &at_rest)
    );
    assert!(distance_m(&back, &motion.inverse(), &moved) < 0.001);
    assert!(distance_m(&forth, &motion, &at_rest) < 0.001);
    assert!(distance_m(&(back * forth), &Isometry3::identity(), &at_rest) < 0.001);
}

#[test]
fn the_first_view_makes_the_frame() {
    let (points, _) = block_and_moved(22, &Isometry3::identity());
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    let evidence = registrar.add_view(&points, None).unwrap();
    assert_eq!(evidence.stop_reason, StopReason::FirstView);
    assert_eq!(evidence.transform, Isometry3::identity());
    assert!(!registrar.in_hand_frame());
    assert!(registrar.cloud().len() > 1000);
}

#[test]
fn the_same_views_give_the_same_answer() {
    let motion = about_object(
        Vector3::new(0.002, 0.001, 0.0),
        Vector3::new(0.0, 0.03, 0.06),
    );
    let (a, b) = block_and_moved(23, &motion);
    let run = || register(Parameters::default(), [(&a[..], None), (&b[..], None)]).unwrap();
    let ((first, first_evidence), (second, second_evidence)) = (run(), run());
    assert_eq!(first_evidence, second_evidence);
    assert_eq!(first.cloud(), second.cloud());
}

#[test]
fn a_view_of_something_elsewhere_is_refused_and_left_out() {
    let (points, _) = block_and_moved(24, &Isometry3::identity());
    let elsewhere: Vec<_> = points
        .iter()
        .map(|point| point + Vector3::new(0.3, 0.0, 0.0))
        .collect();
    let (registrar, evidence) = register(
        Parameters::default(),
        [(&points[..], None), (&elsewhere[..], None)],
    )
    .unwrap();
    assert!(!evidence[1].accepted && !evidence[1].reason.is_empty());
    assert_eq!(evidence[1].stop_reason, StopReason::Refused);
    let mut alone = Registrar::new(Parameters::default()).unwrap();
    alone.add_view(&points, None).unwrap();
    assert_eq!(registrar.cloud(), alone.cloud());
}
