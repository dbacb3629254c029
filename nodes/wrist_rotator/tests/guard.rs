//! Each rule of refusal, alone, before and during a motion.
#![allow(clippy::unwrap_used, missing_docs)]

use std::time::{Duration, Instant};

use baxter::{EstopButton, EstopSource, RobotState, Side, StateRefusal, W2};
use wrist_rotator::{
    Guard, Monitor, Motion, MotionError, Parameters, Refusal, Snapshot, Surroundings,
};

const HEALTHY: RobotState = RobotState::HEALTHY;

/// A robot that may move, as seen at `now`.
fn healthy(now: Instant) -> Monitor {
    let mut monitor = Monitor::new(Side::Left);
    monitor.state(HEALTHY, now);
    let names = Side::Left.joint_names().map(String::from);
    monitor.joint_states(&names, &[0.1; 7], &[0.0; 7], Duration::from_secs(100), now);
    monitor.cuff(false, now);
    monitor.collision_objects(vec![], now);
    monitor.collision_detected(false, now);
    monitor.other_publishers(Some(vec![]));
    monitor
}

fn refusal(parameters: &Parameters, spoil: impl Fn(&mut Monitor, Instant)) -> Option<Refusal> {
    let now = Instant::now() + Duration::from_secs(10);
    let mut monitor = healthy(now);
    spoil(&mut monitor, now);
    let start = |monitor: &Monitor| Motion::start(parameters, monitor.snapshot(), 0.5, now);
    let at_start = start(&monitor).err().map(refusal_of);
    let mut motion = start(&healthy(now)).unwrap();
    motion.step(monitor.snapshot(), now + Duration::from_millis(10));
    let in_motion = motion.ending().cloned().map(refusal_of);
    match (&at_start, &in_motion) {
        (Some(Refusal::PublishersUnknown), None) => {}
        // Ages differ by the tick; the kind must be the same.
        (Some(start), Some(running)) => {
            assert_eq!(
                std::mem::discriminant(start),
                std::mem::discriminant(running)
            );
        }
        (None, None) => {}
        other => panic!("start and motion disagree: {other:?}"),
    }
    at_start
}

fn refusal_of(error: MotionError) -> Refusal {
    match error {
        MotionError::Refused(refusal) => refusal,
        other => panic!("{other}"),
    }
}

fn refused(spoil: impl Fn(&mut Monitor, Instant)) -> Refusal {
    refusal(&Parameters::default(), spoil).unwrap()
}

#[test]
fn a_healthy_robot_may_move() {
    assert_eq!(refusal(&Parameters::default(), |_, _| {}), None);
}

#[test]
fn nothing_heard_is_named() {
    let now = Instant::now();
    let guard = Guard::new(&Parameters::default());
    let refusal = guard
        .check_start(&Snapshot::default(), 0.0, now)
        .unwrap_err();
    assert_eq!(refusal, StateRefusal::Absent.into());
    let mut monitor = Monitor::new(Side::Left);
    monitor.state(HEALTHY, now);
    let refusal = guard
        .check_start(monitor.snapshot(), 0.0, now)
        .unwrap_err()
        .to_string();
    assert!(
        refusal.contains("left_s0") && refusal.contains("left_w2"),
        "{refusal}"
    );
}

#[test]
fn old_news_is_refused_with_its_age() {
    let state = refused(|monitor, now| monitor.state(HEALTHY, now - Duration::from_millis(510)));
    assert!(
        matches!(state, Refusal::State(StateRefusal::Stale { age_s, .. }) if (age_s - 0.51).abs() < 1e-6)
    );
    let joints = refused(|monitor, now| {
        let names = ["left_e1".to_owned()];
        let received = now - Duration::from_millis(250);
        monitor.joint_states(&names, &[0.1], &[], Duration::from_secs(100), received);
    });
    assert!(
        matches!(
            joints,
            Refusal::JointsStale {
                joint: "left_e1",
                ..
            }
        ),
        "{joints}"
    );
}

#[test]
fn each_bad_state_is_refused_by_its_name() {
    let with = |state: RobotState| refused(move |monitor, now| monitor.state(state, now));
    assert_eq!(
        with(RobotState {
            enabled: false,
            ..HEALTHY
        }),
        StateRefusal::NotEnabled.into()
    );
    assert_eq!(
        with(RobotState {
            stopped: true,
            ..HEALTHY
        }),
        StateRefusal::Stopped.into()
    );
    assert_eq!(
        with(RobotState {
            error: true,
            ..HEALTHY
        }),
        StateRefusal::Error.into()
    );
    let pressed = RobotState {
        enabled: false,
        stopped: true,
        estop_button: EstopButton::Pressed,
        ..HEALTHY
    };
    let text = with(RobotState {
        estop_source: EstopSource::User,
        ..pressed
    })
    .to_string();
    assert!(text.contains("button pressed, source user"), "{text}");
    let text = with(RobotState {
        estop_button: EstopButton::Released,
        ..HEALTHY
    })
    .to_string();
    assert!(text.contains("released"), "{text}");
    let text = with(RobotState {
        estop_source: EstopSource::Other(77),
        ..HEALTHY
    })
    .to_string();
    assert!(text.contains("source 77"), "{text}");
}

#[test]
fn ready_and_error_are_policies() {
    let not_ready = |monitor: &mut Monitor, now| {
        monitor.state(
            RobotState {
                ready: false,
                ..HEALTHY
            },
            now,
        );
    };
    assert_eq!(refusal(&Parameters::default(), not_ready), None);
    let strict = Parameters {
        require_ready: true,
        ..Default::default()
    };
    assert_eq!(
        refusal(&strict, not_ready),
        Some(StateRefusal::NotReady.into())
    );
    let error = |monitor: &mut Monitor, now| {
        monitor.state(
            RobotState {
                error: true,
                ..HEALTHY
            },
            now,
        );
    };
    let lenient = Parameters {
        tolerate_error: true,
        ..Default::default()
    };
    assert_eq!(refusal(&lenient, error), None);
}

#[test]
fn targets_out_of_range_or_not_finite_are_refused() {
    let now = Instant::now();
    let monitor = healthy(now);
    let start = |target_rad| {
        let parameters = Parameters::default();
        let started = Motion::start(&parameters, monitor.snapshot(), target_rad, now);
        started.err().map(refusal_of)
    };
    assert!(matches!(
        start(f64::NAN),
        Some(Refusal::TargetNotFinite { .. })
    ));
    assert!(matches!(
        start(f64::INFINITY),
        Some(Refusal::TargetNotFinite { .. })
    ));
    assert!(matches!(
        start(3.06),
        Some(Refusal::TargetOutsideLimits { .. })
    ));
    assert!(matches!(
        start(-3.06),
        Some(Refusal::TargetOutsideLimits { .. })
    ));
    assert_eq!(start(3.059), None);
}

#[test]
fn other_commanders_cuff_and_collisions_are_refused() {
    let other = refused(|monitor, _| monitor.other_publishers(Some(vec!["/tuck_arms".into()])));
    assert!(other.to_string().contains("/tuck_arms"));
    let unknown = refused(|monitor, _| monitor.other_publishers(None));
    assert_eq!(unknown, Refusal::PublishersUnknown);
    assert_eq!(
        refused(|monitor, now| monitor.cuff(true, now)),
        Refusal::CuffHeld
    );
    let near = refused(|monitor, now| monitor.collision_objects(vec!["right_wrist".into()], now));
    assert!(near.to_string().contains("right_wrist"));
    let impact = refused(|monitor, now| monitor.collision_detected(true, now));
    assert!(matches!(impact, Refusal::Collision { .. }));
}

#[test]
fn an_angle_that_is_no_number_is_refused() {
    let refusal = refused(|monitor, now| {
        let names = ["left_w0".to_owned()];
        monitor.joint_states(&names, &[f64::NAN], &[], Duration::from_secs(100), now);
    });
    assert!(matches!(
        refusal,
        Refusal::JointNotFinite {
            joint: "left_w0",
            ..
        }
    ));
}

#[test]
fn joints_are_found_by_name_in_any_layout() {
    let now = Instant::now();
    let mut monitor = healthy(now);
    let stamp = Duration::from_secs(101);
    monitor.joint_states(
        &["l_gripper_l_finger_joint".into()],
        &[0.02],
        &[],
        stamp,
        now,
    );
    let names = [
        "torso_t0".to_owned(),
        "left_w2".to_owned(),
        "left_s0".to_owned(),
    ];
    monitor.joint_states(&names, &[-12.566, 0.4], &[0.0], stamp, now);
    let sample = |index: usize| monitor.snapshot().joints[index].unwrap().value;
    assert_eq!(
        (sample(W2).angle_rad, sample(W2).velocity_rad_s),
        (0.4, None)
    );
    assert_eq!(
        sample(0).angle_rad,
        0.1,
        "the message was too short to hold left_s0"
    );
}

#[test]
fn surroundings_must_be_heard_and_fresh_unless_waived() {
    let now = Instant::now() + Duration::from_secs(10);
    let old = now.checked_sub(Duration::from_millis(600)).unwrap();
    let check = |parameters: &Parameters, monitor: &Monitor| {
        let checked = Guard::new(parameters).check(monitor.snapshot(), now);
        checked.err().map(|refusal| refusal.to_string())
    };
    let strict = Parameters::default();
    for (what, topic) in [
        (
            Surroundings::Cuff,
            "/robot/digital_io/left_lower_cuff/state",
        ),
        (
            Surroundings::CollisionAvoidance,
            "/robot/limb/left/collision_avoidance_state",
        ),
        (
            Surroundings::CollisionDetection,
            "/robot/limb/left/collision_detection_state",
        ),
    ] {
        let waived = Parameters {
            waived: vec![what],
            ..Default::default()
        };
        let mut never = Monitor::new(Side::Left);
        never.state(HEALTHY, now);
        let names = Side::Left.joint_names().map(String::from);
        never.joint_states(&names, &[0.1; 7], &[0.0; 7], Duration::from_secs(100), now);
        let mut stale = healthy(now);
        let hear_all_but = |monitor: &mut Monitor| {
            let heard = |other| if other == what { None } else { Some(now) };
            if let Some(now) = heard(Surroundings::Cuff) {
                monitor.cuff(false, now);
            }
            if let Some(now) = heard(Surroundings::CollisionAvoidance) {
                monitor.collision_objects(vec![], now);
            }
            if let Some(now) = heard(Surroundings::CollisionDetection) {
                monitor.collision_detected(false, now);
            }
        };
        hear_all_but(&mut never);
        match what {
            Surroundings::Cuff => stale.cuff(false, old),
            Surroundings::CollisionAvoidance => stale.collision_objects(vec![], old),
            Surroundings::CollisionDetection => stale.collision_detected(false, old),
        }
        let text = check(&strict, &never).unwrap();
        assert!(
            text.contains(&format!("no message on {topic} yet")),
            "{text}"
        );
        assert!(
            text.contains(&format!("name {} in ~waived", what.name())),
            "{text}"
        );
        let text = check(&strict, &stale).unwrap();
        assert!(
            text.contains(&format!("last message on {topic} is 0.60 s old")),
            "{text}"
        );
        assert_eq!(check(&waived, &never), None);
        assert_eq!(check(&waived, &stale), None);
    }
}

#[test]
fn what_is_waived_still_counts_where_it_is_heard() {
    let waived = Parameters {
        waived: vec![Surroundings::Cuff],
        ..Default::default()
    };
    let held = |monitor: &mut Monitor, now| monitor.cuff(true, now);
    assert_eq!(refusal(&waived, held), Some(Refusal::CuffHeld));
}
