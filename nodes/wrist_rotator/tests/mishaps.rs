//! Motions on the simulated arm that are ended, blocked or held up.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use baxter::{Side, StateRefusal, W2};
use support::Bench;
use wrist_rotator::{MotionError, Refusal, Step};

const NONE: [&str; 0] = [];

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
