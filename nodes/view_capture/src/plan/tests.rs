#![allow(clippy::unwrap_used)]
use super::*;
use rand::{RngExt, SeedableRng};

fn close(angles: &[f64], expected: &[f64]) -> bool {
    angles.len() == expected.len()
        && angles
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12)
}

#[test]
fn views_spread_about_the_centre() {
    let parameters = Parameters::default();
    assert!(close(&plan(&parameters, 0).unwrap(), &[-0.6, 0.0, 0.6]));
    assert!(close(&plan(&parameters, 1).unwrap(), &[0.0]));
    assert!(close(&plan(&parameters, 2).unwrap(), &[-0.3, 0.3]));
}

#[test]
fn many_views_stay_within_the_range() {
    let parameters = Parameters::default();
    let angles = plan(&parameters, 36).unwrap();
    assert_eq!(angles.len(), 36);
    assert!(angles.iter().all(|angle| angle.abs() <= 3.0 + 1e-12));
    assert!((angles[35] - 3.0).abs() < 1e-12 && (angles[0] + 3.0).abs() < 1e-12);
    assert_eq!(
        plan(&parameters, 65),
        Err(PlanError::TooMany {
            asked: 65,
            most: 64
        })
    );
}

#[test]
fn a_scan_near_the_limit_is_moved_inside() {
    let parameters = Parameters {
        centre_angle_rad: 2.9,
        ..Default::default()
    };
    assert!(close(&plan(&parameters, 3).unwrap(), &[1.8, 2.4, 3.0]));
}

fn is_sweep(parameters: &Parameters, views: u32, range_rad: f64) -> bool {
    let plan = plan_scan(parameters, views, range_rad).unwrap();
    matches!(plan, WristPlan::Sweep { .. })
}

#[test]
fn who_asks_for_views_gets_rests_and_who_asks_for_a_range_a_sweep() {
    let sweeping = Parameters {
        motion: Motion::Sweep,
        ..Default::default()
    };
    let stepping = Parameters {
        motion: Motion::Steps,
        ..Default::default()
    };
    assert!(is_sweep(&sweeping, 0, 0.0) && is_sweep(&stepping, 0, 1.0));
    assert!(!is_sweep(&sweeping, 3, 0.0) && !is_sweep(&stepping, 0, 0.0));
    let blind = Parameters {
        use_tf: false,
        ..sweeping
    };
    assert!(!is_sweep(&blind, 0, 0.0));
    assert_eq!(plan_scan(&blind, 0, 1.0), Err(PlanError::NoKinematics));
}

#[test]
fn a_range_that_is_used_up_is_no_panic() {
    let seed = rand::random();
    println!("seed {seed}");
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
    let exact = Parameters {
        centre_angle_rad: -0.6,
        angle_min_rad: -1.7,
        angle_max_rad: 0.4,
        ..Default::default()
    };
    assert_eq!(plan(&exact, 5).unwrap().len(), 5);
    for _ in 0..10_000 {
        let (one, other) = (
            random.random_range(-7.0..7.0),
            random.random_range(-7.0..7.0),
        );
        let (min_rad, max_rad) = (f64::min(one, other), f64::max(one, other));
        let parameters = Parameters {
            angle_min_rad: min_rad,
            angle_max_rad: max_rad,
            centre_angle_rad: random.random_range(min_rad..=max_rad),
            view_step_rad: (max_rad - min_rad).max(0.01) / f64::from(random.random_range(1..9)),
            ..Default::default()
        };
        let angles = plan(&parameters, random.random_range(1..=64)).unwrap();
        assert_eq!(check(&parameters, &angles), Ok(()), "{parameters:?}");
    }
}

#[test]
fn angles_outside_the_range_are_named() {
    let parameters = Parameters::default();
    assert_eq!(check(&parameters, &[-3.0, 3.0]), Ok(()));
    for bad in [3.1, f64::NAN, f64::NEG_INFINITY] {
        let error = check(&parameters, &[0.0, bad]).unwrap_err().to_string();
        assert!(error.contains(&format!("{bad} rad")), "{error}");
    }
    assert!(check(&parameters, &[0.0; 65]).is_err());
}
