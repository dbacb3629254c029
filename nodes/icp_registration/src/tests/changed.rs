//! Hands that do not hold in one view what they held in another.

use nalgebra::{Isometry3, Point3, Vector3};
use rand_pcg::Pcg64Mcg;

use super::scene::{self, Spot, about_object, hand_from_camera};
use crate::{Parameters, Registrar, RegistrationError, ViewEvidence};

const NOISE_M: f64 = 0.0006;
const ANGLES_RAD: [f64; 3] = [-0.6, 0.0, 0.6];

/// A gripper: a block with two posts below where the object stands.
fn gripper(random: &mut Pcg64Mcg) -> Vec<Spot> {
    let block = scene::block(random, 12_000);
    let shrunk = |scale: Vector3<f64>, middle: Point3<f64>| {
        let spots = block.clone().into_iter();
        spots.map(move |(place, normal)| {
            let aside = place - Point3::new(0.0, 0.0, 0.1877);
            (middle + aside.component_mul(&scale), normal)
        })
    };
    let base = shrunk(Vector3::new(0.8, 0.8, 0.7), Point3::new(0.0, 0.0, 0.07));
    let post = Vector3::new(0.3, 0.1, 0.25);
    let left = shrunk(post, Point3::new(0.0, 0.06, 0.135));
    let right = shrunk(post, Point3::new(0.0, -0.06, 0.135));
    base.chain(left).chain(right).collect()
}

fn moved(spots: &[Spot], motion: &Isometry3<f64>) -> Vec<Spot> {
    let spots = spots.iter();
    spots
        .map(|(place, normal)| (motion * place, motion * normal))
        .collect()
}

/// Views of a gripper with what it holds in each, where the camera mount is off by `mount`.
fn scan(
    random: &mut Pcg64Mcg,
    held: [&[Spot]; 3],
    mount: &Isometry3<f64>,
) -> (Registrar, Vec<Result<ViewEvidence, RegistrationError>>) {
    let gripper = gripper(random);
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    let views = ANGLES_RAD.into_iter().zip(held);
    let results = views.map(|(wrist_rad, held)| {
        let truth = hand_from_camera(wrist_rad);
        let spots = [&gripper[..], held].concat();
        let view = scene::view(random, &spots, &truth, NOISE_M);
        registrar.add_view(&view, Some(truth * mount))
    });
    let results = results.collect();
    (registrar, results)
}

fn second_view(random: &mut Pcg64Mcg, first: &[Spot], then: &[Spot]) -> RegistrationError {
    let (registrar, mut results) = scan(random, [first, then, then], &Isometry3::identity());
    let error = results.swap_remove(1).unwrap_err();
    println!("{error}");
    assert_eq!(registrar.count().registered, 1, "what failed was fused");
    error
}

#[test]
fn the_same_object_in_all_views_is_not_doubted() {
    let mut random = scene::random(61);
    for held in [
        scene::block(&mut random, 15_000),
        scene::tube(&mut random, 0.033, 15_000),
    ] {
        let mount = Isometry3::new(
            Vector3::new(0.004, 0.0, 0.003),
            Vector3::new(0.01, 0.01, 0.0),
        );
        let (registrar, results) = scan(&mut random, [&held; 3], &mount);
        for evidence in results {
            let comparison = evidence.unwrap().comparison;
            assert!(comparison.object.largest() < 0.05, "{comparison:?}");
        }
        assert_eq!(registrar.count().registered, 3);
        assert_eq!(registrar.doubt(), None);
    }
}

#[test]
fn a_dropped_object_is_named() {
    let mut random = scene::random(62);
    let block = scene::block(&mut random, 15_000);
    let error = second_view(&mut random, &block, &[]);
    assert!(matches!(error, RegistrationError::Dropped { gone } if gone > 0.5));
}

#[test]
fn an_object_that_is_put_in_later_is_named() {
    let mut random = scene::random(63);
    let block = scene::block(&mut random, 15_000);
    let error = second_view(&mut random, &[], &block);
    assert!(matches!(error, RegistrationError::PutIn { new } if new > 0.5));
}

#[test]
fn another_object_is_named() {
    let mut random = scene::random(64);
    let (block, tube) = (
        scene::block(&mut random, 15_000),
        scene::tube(&mut random, 0.033, 15_000),
    );
    for [first, then] in [[&block, &tube], [&tube, &block]] {
        let error = second_view(&mut random, first, then);
        assert!(matches!(error, RegistrationError::Swapped { .. }));
    }
}

#[test]
fn an_object_that_slips_is_named_or_its_view_refused() {
    let mut random = scene::random(65);
    let block = scene::block(&mut random, 15_000);
    let slip = about_object(
        Vector3::new(0.02, 0.012, -0.015),
        Vector3::new(0.1, 0.0, 0.1),
    );
    let slipped = moved(&block, &slip);
    let held = [&block[..], &slipped, &slipped];
    let (registrar, results) = scan(&mut random, held, &Isometry3::identity());
    let error = results[1].as_ref().map(|evidence| &evidence.reason[..]);
    println!("{error:?}");
    match error {
        Err(RegistrationError::Slipped { .. } | RegistrationError::Swapped { .. }) => {}
        Err(other) => panic!("{other}"),
        Ok(reason) => assert!(reason.contains("slip"), "{reason:?}"),
    }
    assert_eq!(registrar.count().registered, 1);
}

/// Seen in every view of the turning hand, and told from an object that moved by the gripper, which is off as well.
#[test]
fn a_mount_that_is_off_is_said_with_how_far() {
    let mut random = scene::random(66);
    let block = scene::block(&mut random, 15_000);
    let mount = Isometry3::new(Vector3::new(0.02, 0.0, 0.015), Vector3::new(0.0, 0.0, 0.06));
    let (registrar, results) = scan(&mut random, [&block; 3], &mount);
    assert!(results.iter().all(Result::is_ok), "{results:?}");
    let doubt = registrar.doubt().unwrap();
    println!("{doubt}");
    assert!(doubt.contains("camera mount is off"), "{doubt}");
}

#[test]
fn a_cloud_of_refused_views_is_doubted() {
    let mut random = scene::random(67);
    let block = scene::block(&mut random, 15_000);
    let mut registrar = Registrar::new(Parameters {
        max_correction_m: 0.001,
        ..Parameters::default()
    })
    .unwrap();
    let error = about_object(Vector3::new(0.005, 0.0, 0.0), Vector3::zeros());
    for (wrist_rad, error) in [(-0.6, Isometry3::identity()), (0.0, error)] {
        let truth = hand_from_camera(wrist_rad);
        let view = scene::view(&mut random, &block, &truth, NOISE_M);
        registrar.add_view(&view, Some(error * truth)).unwrap();
    }
    let count = registrar.count();
    assert_eq!((count.registered, count.refused), (1, 1));
    let doubt = registrar.doubt().unwrap();
    assert!(
        doubt.starts_with("1 of 2 views were refused, the last because it would be moved by"),
        "{doubt}"
    );
}
