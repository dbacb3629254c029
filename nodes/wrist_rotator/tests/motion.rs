//! Whole motions on the simulated arm.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use std::time::Duration;

use baxter::{Side, W2};
use support::Bench;
use wrist_rotator::{Motion, Parameters, Step, Turn};

const NONE: [&str; 0] = [];

#[test]
fn turns_0_6_rad_within_1_2_s_settling_included() {
    let mut bench = Bench::new();
    for target_rad in [0.6, 0.0, -0.6] {
        let mut motion = bench.start(target_rad);
        let (ended, elapsed_s) = bench.carry_out(&mut motion, |_, _, _| {});
        let arrived = ended.result.unwrap();
        println!(
            "{target_rad}: {elapsed_s:.2} s, at {:.5} rad",
            arrived.angle_rad
        );
        assert!(elapsed_s <= 1.2, "{elapsed_s} s");
        assert!((bench.w2().0 - target_rad).abs() < 0.0087);
        let dwell = Duration::from_secs_f64(Parameters::default().dwell_s);
        assert!(bench.stamp - arrived.at_rest >= dwell);
    }
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn arrives_across_the_whole_range_and_where_it_already_is() {
    let mut bench = Bench::new();
    for target_rad in [3.05, -3.05, -3.05] {
        let mut motion = bench.start(target_rad);
        let (ended, _) = bench.carry_out(&mut motion, |_, _, _| {});
        assert!(ended.result.is_ok());
        assert!((bench.w2().0 - target_rad).abs() < 0.0087);
    }
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn a_turn_at_a_rate_says_when_the_rate_was_constant() {
    let mut bench = Bench::new();
    for (target_rad, rate_rad_s) in [(1.2, 1.15), (0.0, 0.4), (2.9, 0.9)] {
        let from_rad = bench.w2().0;
        let turn = Turn {
            target_rad,
            rate_rad_s: Some(rate_rad_s),
        };
        let mut motion = bench.start(turn);
        let mut track = vec![];
        let (ended, elapsed_s) = bench.carry_out(&mut motion, |bench, _, _| {
            let commanded = bench.monitor.snapshot().commanded;
            let commanded_rad = commanded.map(|command| command.value[W2]);
            track.push((bench.stamp, commanded_rad, bench.w2().0));
        });
        assert!(ended.result.is_ok());
        let constant = ended.constant.unwrap();
        let lasted_s = (constant.until - constant.from).as_secs_f64();
        // The way less the ramps, which take the wrist from rest to the rate within 5 rad/s² and 80 rad/s³.
        let ramp_s = rate_rad_s / 5.0 + 5.0 / 80.0;
        let expected_s = (target_rad - from_rad).abs() / rate_rad_s - ramp_s;
        assert!(
            (lasted_s - expected_s).abs() < 0.05,
            "{lasted_s} s, expected {expected_s}"
        );
        assert!(elapsed_s < lasted_s + 2.0 * ramp_s + 0.2, "{elapsed_s} s");
        // The arm comes up to the rate of the setpoints with a time constant of up to 60 ms.
        let late = Duration::from_millis(180);
        let within = |pair: &&[(Duration, Option<f64>, f64)]| {
            pair[0].0 > constant.from && pair[1].0 <= constant.until
        };
        let steady: Vec<_> = track.windows(2).filter(within).collect();
        assert!(steady.len() > 30);
        for pair in steady {
            let commanded_rad = pair[1].1.unwrap() - pair[0].1.unwrap();
            let commanded_rad_s = commanded_rad.abs() / support::TICK_S;
            assert!(
                (commanded_rad_s - rate_rad_s).abs() < 1e-6,
                "{commanded_rad_s} rad/s commanded"
            );
            let speed_rad_s = (pair[1].2 - pair[0].2).abs() / support::TICK_S;
            assert!(
                pair[0].0 <= constant.from + late || (speed_rad_s - rate_rad_s).abs() < 0.01,
                "{speed_rad_s} rad/s"
            );
        }
    }
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn a_way_too_short_for_the_rate_has_no_constant_part_and_a_hold_begins_it_anew() {
    let mut bench = Bench::new();
    let mut motion = bench.start(0.05);
    let (ended, _) = bench.carry_out(&mut motion, |_, _, _| {});
    assert!(ended.result.is_ok() && ended.constant.is_none());
    let mut motion = bench.start(2.5);
    let mut released = None;
    let (ended, _) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
        let is_jammed = (0.8..1.1).contains(&elapsed_s);
        bench.robot.arm_mut(Side::Left).jam(W2, is_jammed);
        if is_jammed {
            released = Some(bench.stamp);
        }
    });
    assert!(ended.result.is_ok());
    assert!(ended.constant.unwrap().from > released.unwrap());
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn rates_that_cannot_be_are_refused_by_name() {
    let bench = Bench::new();
    let parameters = Parameters::default();
    for rate_rad_s in [f64::NAN, -0.5, 0.01, 1.2, f64::INFINITY] {
        let turn = Turn {
            target_rad: 0.5,
            rate_rad_s: Some(rate_rad_s),
        };
        let started = Motion::start(&parameters, bench.monitor.snapshot(), turn, bench.now);
        let text = started.unwrap_err().to_string();
        let words = ["0.05 to 1.15", "velocity_max_rad_s"];
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
}

#[test]
fn leaves_the_other_joints_where_they_are() {
    let mut bench = Bench::new();
    let before = bench.robot.arm(Side::Left).angles_rad();
    let mut motion = bench.start(0.6);
    bench.carry_out(&mut motion, |_, _, _| {});
    let after = bench.robot.arm(Side::Left).angles_rad();
    for joint in 0..W2 {
        assert!((after[joint] - before[joint]).abs() < 5e-4, "joint {joint}");
    }
}

/// A turn that ended without having seen the arm at rest, as on a starved computer.
#[test]
fn no_turn_starts_from_an_arm_that_still_moves() {
    let mut bench = Bench::new();
    let mut motion = bench.start(2.0);
    for _ in 0..60 {
        match motion.step(bench.monitor.snapshot(), bench.now) {
            Step::Command(angles_rad) => bench.obey(angles_rad),
            step => panic!("{step:?}"),
        }
        bench.tick();
    }
    let start = |bench: &Bench| {
        Motion::start(
            &Parameters::default(),
            bench.monitor.snapshot(),
            0.0,
            bench.now,
        )
    };
    let text = start(&bench).unwrap_err().to_string();
    assert!(text.contains("left_w2 still moves at"), "{text}");
    (0..50).for_each(|_| bench.tick());
    assert!(start(&bench).is_ok());
}
