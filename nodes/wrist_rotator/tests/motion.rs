//! Whole motions on the simulated arm.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use std::time::Duration;

use baxter::{Side, StateRefusal, W2};
use support::Bench;
use wrist_rotator::{Motion, MotionError, Parameters, Refusal, Step, Turn};

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

#[test]
fn an_emergency_stop_ends_the_commands_at_the_next_tick() {
    let mut bench = Bench::new();
    let mut motion = bench.start(2.0);
    let (ended, _) = bench.carry_out(&mut motion, |bench, motion, elapsed_s| {
        if elapsed_s > 0.5 && bench.robot.assembly.allows_motion() {
            bench.robot.assembly.press_estop();
            bench.tick();
            let step = motion.step(bench.monitor.snapshot(), bench.now);
            assert_eq!(step, Step::Wait);
        }
    });
    let error = ended.result.unwrap_err();
    let refusal = Refusal::State(StateRefusal::EmergencyStop {
        button: baxter::EstopButton::Pressed,
        source_name: baxter::EstopSource::User,
    });
    assert_eq!(error, MotionError::Refused(refusal));
    let stopped_at = bench.w2().0;
    assert_eq!(bench.w2().1, 0.0, "the answer comes once the arm rests");
    bench.robot.assembly.release_estop();
    bench.robot.assembly.reset();
    bench.robot.assembly.enable(true);
    (0..200).for_each(|_| bench.tick());
    assert!(
        (bench.w2().0 - stopped_at).abs() < 1e-3,
        "nobody moved it on"
    );
    let mut motion = bench.start(0.0);
    let (ended, _) = bench.carry_out(&mut motion, |_, _, _| {});
    assert!(ended.result.is_ok());
    assert_eq!(bench.violations(), NONE);
}

/// What ends a motion, and what does it.
type Case = (&'static str, fn(&mut Bench, &mut wrist_rotator::Motion));

#[test]
fn each_end_comes_to_rest_along_a_ramp_within_a_quarter_of_a_second() {
    let cases: [Case; 6] = [
        ("stop_wrist", |bench, motion| {
            motion.end(MotionError::Stopped, bench.now);
        }),
        ("hung up", |bench, motion| {
            let reason = MotionError::NobodyWaits("the caller /x hung up or died".into());
            motion.end(reason, bench.now);
        }),
        ("/tuck_arms", |bench, _| {
            let others = Some(vec!["/tuck_arms".into()]);
            bench.monitor.other_publishers(others);
        }),
        ("collision reported (table)", |bench, _| {
            bench
                .robot
                .set_collision_objects(Side::Left, vec!["table".into()]);
            bench.publish(bench.now);
        }),
        ("impact detected", |bench, _| {
            bench.robot.set_impact(Side::Left, true);
            bench.publish(bench.now);
        }),
        ("reports nan rad for left_e1", |bench, _| {
            let names = ["left_e1".to_owned()];
            let (stamp, now) = (bench.stamp, bench.now);
            bench
                .monitor
                .joint_states(&names, &[f64::NAN], &[], stamp, now);
            bench.silent = vec!["joint_states"];
        }),
    ];
    for (words, end) in cases {
        // In the middle of speeding up, at full speed, and while slowing down.
        for at_s in [0.1, 0.5, 1.55] {
            let mut bench = Bench::new();
            let mut motion = bench.start(1.5);
            let mut rested_s = None;
            let (ended, _) = bench.carry_out(&mut motion, |bench, motion, elapsed_s| {
                if (elapsed_s - at_s).abs() < 1e-6 {
                    end(bench, motion);
                }
                if elapsed_s > at_s && bench.w2().1.abs() < 0.02 {
                    rested_s.get_or_insert(elapsed_s - at_s);
                    // Seen at rest only if it is heard.
                    bench.silent.clear();
                }
            });
            let error = ended.result.unwrap_err().to_string();
            assert!(error.to_lowercase().contains(words), "{error}");
            assert!(ended.rest.is_some(), "{words} at {at_s} s");
            let rested_s = rested_s.unwrap();
            assert!(rested_s <= 0.25, "{words} at {at_s} s: {rested_s} s");
            assert_eq!(bench.violations(), NONE, "{words} at {at_s} s");
        }
    }
}

#[test]
fn each_topic_that_falls_silent_ends_the_motion() {
    for topic in [
        "joint_states",
        "state",
        "cuff",
        "collision_avoidance",
        "collision_detection",
    ] {
        let mut bench = Bench::new();
        let mut motion = bench.start(2.9);
        let (ended, elapsed_s) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
            if elapsed_s > 0.5 {
                bench.silent = vec![topic];
            }
        });
        let error = ended.result.unwrap_err().to_string();
        assert!(error.contains("s old"), "{error}");
        assert!(error.contains(topic) || topic == "joint_states", "{error}");
        assert!(bench.w2().0 < 1.6, "{topic}");
        assert_eq!(ended.rest.is_none(), topic == "joint_states");
        assert!(elapsed_s < 3.6, "{topic}: {elapsed_s} s");
        assert_eq!(bench.violations(), NONE, "{topic}");
    }
}

#[test]
fn a_cuff_that_is_held_takes_the_arm_out_of_command_at_once() {
    let mut bench = Bench::new();
    let mut motion = bench.start(2.0);
    let (ended, _) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
        if elapsed_s > 0.5 {
            bench.robot.hold_cuff(Side::Left, true);
        }
        if elapsed_s > 0.53 {
            assert!(
                bench.robot.arm(Side::Left).position_goals_rad()[W2].is_none(),
                "no setpoint waits for the cuff's release"
            );
        }
    });
    assert_eq!(ended.result, Err(Refusal::CuffHeld.into()));
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn a_command_topic_that_froze_is_noticed() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let error = loop {
        // The command is lost on its way.
        if let Step::Ended(ended) = motion.step(bench.monitor.snapshot(), bench.now) {
            break ended.result.unwrap_err();
        }
        bench.tick();
    };
    assert!(matches!(error, MotionError::NotFollowing { .. }), "{error}");
    assert_eq!(bench.w2().0, 0.0);
}

#[test]
fn an_arm_that_is_stuck_for_a_while_is_waited_for_and_goes_on_from_rest() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let (ended, _) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
        let stuck = (0.5..1.2).contains(&elapsed_s);
        bench.robot.arm_mut(Side::Left).jam(W2, stuck);
        let goal_rad = bench.robot.arm(Side::Left).position_goals_rad()[W2];
        let ahead_rad = goal_rad.map_or(0.0, |goal_rad| goal_rad - bench.w2().0);
        assert!(ahead_rad < 0.32, "{ahead_rad} rad ahead of the arm");
    });
    assert!((ended.result.unwrap().angle_rad - 1.5).abs() < 0.0087);
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn an_arm_that_stays_stuck_does_not_move_when_it_comes_free_after_the_answer() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let (ended, _) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
        bench.robot.arm_mut(Side::Left).jam(W2, elapsed_s > 0.5);
    });
    let error = ended.result.unwrap_err();
    assert!(matches!(error, MotionError::NotFollowing { .. }), "{error}");
    let stuck_rad = bench.w2().0;
    bench.robot.arm_mut(Side::Left).jam(W2, false);
    (0..50).for_each(|_| bench.tick());
    assert!((bench.w2().0 - stuck_rad).abs() < 1e-6);
    assert_eq!(bench.violations(), NONE);
}

#[test]
fn a_blocked_joint_misses_its_deadline() {
    let mut bench = Bench::new();
    bench.robot.arm_mut(Side::Left).jam(W2, true);
    // So short a way that the following error stays within bounds.
    let mut motion = bench.start(0.1);
    let (ended, elapsed_s) = bench.carry_out(&mut motion, |_, _, _| {});
    let error = ended.result.unwrap_err();
    assert!(matches!(error, MotionError::Deadline { .. }), "{error}");
    assert!(elapsed_s < 3.0);
    assert!(error.to_string().contains("left_w2"));
}

#[test]
fn a_commander_that_was_held_up_goes_on_from_rest() {
    for stalled_ticks in [4, 15, 40] {
        let mut bench = Bench::new();
        let mut motion = bench.start(1.5);
        let (ended, _) = bench.carry_out(&mut motion, |bench, _, elapsed_s| {
            if (elapsed_s - 0.6).abs() < 1e-6 {
                // Nobody commands; the joint states remain fresh.
                (0..stalled_ticks).for_each(|_| bench.tick());
            }
        });
        assert!((ended.result.unwrap().angle_rad - 1.5).abs() < 0.0087);
        let violations = bench.violations();
        let unavoidable = |text: &String| stalled_ticks > 20 && text.contains("ends at speed");
        assert!(violations.iter().all(unavoidable), "{violations:?}");
    }
}

/// Preempted between a step and the sending of its command.
#[test]
fn a_command_that_was_held_up_before_it_was_sent_is_no_jump() {
    for held_up_ticks in [2, 4, 9, 14] {
        let mut bench = Bench::new();
        let mut motion = bench.start(1.5);
        let (ended, _) = bench.carry_out(&mut motion, |bench, motion, elapsed_s| {
            if (elapsed_s - 0.6).abs() < 1e-6 {
                let step = motion.step(bench.monitor.snapshot(), bench.now);
                let Step::Command(angles_rad) = step else {
                    panic!("{step:?}")
                };
                (0..held_up_ticks).for_each(|_| bench.tick());
                if motion.may_send(bench.now) {
                    bench.obey(angles_rad);
                }
            }
        });
        assert!((ended.result.unwrap().angle_rad - 1.5).abs() < 0.0087);
        assert_eq!(bench.violations(), NONE, "{held_up_ticks} ticks");
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
