//! The limits, checked on what a robot sees: setpoints one period apart.
#![allow(clippy::unwrap_used)]

use super::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const PERIOD_S: f64 = 0.01;
const LIMITS: RateLimits = RateLimits {
    velocity_rad_s: 1.0,
    acceleration_rad_s2: 5.0,
    jerk_rad_s3: 80.0,
};
const STOP_LIMITS: RateLimits = RateLimits {
    velocity_rad_s: 1.0,
    acceleration_rad_s2: 10.0,
    jerk_rad_s3: 250.0,
};

/// All setpoints until rest, the first included.
fn run(setpoints: &mut Setpoints) -> Vec<f64> {
    let mut angles_rad = vec![setpoints.now().angle_rad];
    while !setpoints.is_resting() {
        angles_rad.push(setpoints.advance().angle_rad);
    }
    angles_rad
}

/// Finite differences: the mean value theorem bounds them by the limits of the curve.
fn check(angles_rad: &[f64], limits: &RateLimits) {
    let at_rest = |angle_rad: Option<&f64>| [*angle_rad.unwrap(); 3];
    let mut values = at_rest(angles_rad.first()).to_vec();
    values.extend(angles_rad);
    values.extend(at_rest(angles_rad.last()));
    for (name, limit) in [
        ("velocity", limits.velocity_rad_s),
        ("acceleration", limits.acceleration_rad_s2),
        ("jerk", limits.jerk_rad_s3),
    ] {
        values = values
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / PERIOD_S)
            .collect();
        let largest = values
            .iter()
            .fold(0.0_f64, |max, value| max.max(value.abs()));
        assert!(
            largest <= limit * 1.001,
            "{name} of {largest}, allowed {limit}"
        );
    }
}

#[test]
fn a_step_of_0_6_rad_takes_0_87_s() {
    let mut setpoints = Setpoints::at_rest(0.0, PERIOD_S);
    assert!(setpoints.is_resting());
    setpoints.go_to(0.6, &LIMITS).unwrap();
    assert!((setpoints.remaining_s() - 0.8625).abs() < 1e-6);
    check(&run(&mut setpoints), &LIMITS);
    assert!((setpoints.now().angle_rad - 0.6).abs() < 1e-9);
    assert_eq!(setpoints.now().velocity_rad_s, 0.0);
}

#[test]
fn limits_hold_on_any_way_and_at_any_stop() {
    let seed: u64 = rand::random();
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for _ in 0..2_000 {
        let [from_rad, to_rad] = [(); 2].map(|()| random.random_range(-3.059..=3.059));
        let mut setpoints = Setpoints::at_rest(from_rad, PERIOD_S);
        setpoints.go_to(to_rad, &LIMITS).unwrap();
        let stop_after = random.random_range(0..400);
        let mut angles_rad = vec![from_rad];
        angles_rad.extend((0..stop_after).map(|_| setpoints.advance().angle_rad));
        setpoints.come_to_rest(&STOP_LIMITS).unwrap();
        assert!(setpoints.remaining_s() <= 0.16 + 1e-9);
        let stop_rad = run(&mut setpoints);
        angles_rad.extend(&stop_rad[1..]);
        check(&angles_rad, &STOP_LIMITS);
        let (low_rad, high_rad) = (from_rad.min(to_rad) - 1e-9, from_rad.max(to_rad) + 1e-9);
        assert!(
            angles_rad
                .iter()
                .all(|angle_rad| (low_rad..=high_rad).contains(angle_rad))
        );
        // On to the target from there.
        setpoints.go_to(to_rad, &LIMITS).unwrap();
        check(&run(&mut setpoints), &LIMITS);
        assert!((setpoints.now().angle_rad - to_rad).abs() < 1e-9);
    }
}

#[test]
fn no_way_at_all_stays() {
    let mut setpoints = Setpoints::at_rest(0.4, PERIOD_S);
    for target_rad in [0.4, 0.4 + 1e-9] {
        setpoints.go_to(target_rad, &LIMITS).unwrap();
        check(&run(&mut setpoints), &LIMITS);
        setpoints.come_to_rest(&STOP_LIMITS).unwrap();
        check(&run(&mut setpoints), &STOP_LIMITS);
    }
}
