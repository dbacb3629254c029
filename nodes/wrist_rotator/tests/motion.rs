//! Whole motions on the simulated arm.
#![allow(clippy::unwrap_used, missing_docs)]

use std::time::{Duration, Instant};

use baxter::{Arrived, Side, StateRefusal, W2};
use sim_baxter::{Kinematics, Robot};
use wrist_rotator::{Monitor, Motion, MotionError, Parameters, Refusal, Step};

const TICK: Duration = Duration::from_millis(10);
const TICK_S: f64 = 0.01;

/// A robot, what is known of it, and the time.
struct Bench {
    robot: Robot,
    monitor: Monitor,
    now: Instant,
    stamp: Duration,
}

impl Bench {
    fn new() -> Self {
        let kinematics = Kinematics::baxter().unwrap();
        let mut parameters = sim_baxter::Parameters::default();
        parameters.scan_pose.left_arm_rad.left_w2 = 0.0;
        let robot = Robot::new(&parameters, &kinematics).unwrap();
        let mut monitor = Monitor::new(Side::Left);
        monitor.other_publishers(Some(vec![]));
        let stamp = Duration::from_secs(1_000);
        let mut bench = Self {
            robot,
            monitor,
            now: Instant::now(),
            stamp,
        };
        bench.tick();
        bench
    }

    /// A hundredth of a second passes; the robot speaks.
    fn tick(&mut self) {
        self.robot.step(TICK_S);
        self.now += TICK;
        self.stamp += TICK;
        let states = self.robot.joint_states();
        let names: Vec<String> = states.names.iter().map(|name| name.to_string()).collect();
        let (positions, velocities) = (&states.positions, &states.velocities);
        self.monitor
            .joint_states(&names, positions, velocities, self.stamp, self.now);
        self.monitor.state(self.robot.assembly.state(), self.now);
    }

    fn start(&self, target_rad: f64) -> Motion {
        let parameters = Parameters::default();
        Motion::start(&parameters, self.monitor.snapshot(), target_rad, self.now).unwrap()
    }

    fn obey(&mut self, angles_rad: [f64; 7]) {
        let names = Side::Left.joint_names().map(String::from);
        let _ = self.robot.command_arm(Side::Left, 1, &names, &angles_rad);
    }

    /// Turns to the target; `disturb` is called before each tick.
    fn turn(
        &mut self,
        target_rad: f64,
        mut disturb: impl FnMut(&mut Self, f64),
    ) -> Result<(Arrived, f64), MotionError> {
        let mut motion = self.start(target_rad);
        let started = self.now;
        loop {
            let elapsed_s = (self.now - started).as_secs_f64();
            disturb(self, elapsed_s);
            match motion.step(self.monitor.snapshot(), self.now)? {
                Step::Arrived(arrived) => return Ok((arrived, elapsed_s)),
                Step::Command(angles_rad) => self.obey(angles_rad),
            }
            self.tick();
        }
    }

    fn w2(&self) -> (f64, f64) {
        let arm = self.robot.arm(Side::Left);
        (arm.angles_rad()[W2], arm.velocities_rad_s()[W2])
    }
}

#[test]
fn turns_0_6_rad_within_1_2_s_settling_included() {
    let mut bench = Bench::new();
    for target_rad in [0.6, 0.0, -0.6] {
        let (arrived, elapsed_s) = bench.turn(target_rad, |_, _| {}).unwrap();
        println!(
            "{target_rad}: {elapsed_s:.2} s, at {:.5} rad",
            arrived.angle_rad
        );
        assert!(elapsed_s <= 1.2, "{elapsed_s} s");
        assert!((bench.w2().0 - target_rad).abs() < 0.0087);
        let dwell = Duration::from_secs_f64(Parameters::default().dwell_s);
        assert!(bench.stamp - arrived.at_rest >= dwell);
    }
}

#[test]
fn arrives_across_the_whole_range_and_where_it_already_is() {
    let mut bench = Bench::new();
    for target_rad in [3.05, -3.05, -3.05] {
        bench.turn(target_rad, |_, _| {}).unwrap();
        assert!((bench.w2().0 - target_rad).abs() < 0.0087);
    }
}

#[test]
fn leaves_the_other_joints_where_they_are() {
    let mut bench = Bench::new();
    let before = bench.robot.arm(Side::Left).angles_rad();
    bench.turn(0.6, |_, _| {}).unwrap();
    let after = bench.robot.arm(Side::Left).angles_rad();
    for joint in 0..W2 {
        assert!((after[joint] - before[joint]).abs() < 5e-4, "joint {joint}");
    }
}

#[test]
fn an_emergency_stop_ends_the_motion_at_the_next_tick() {
    let mut bench = Bench::new();
    let error = bench
        .turn(2.0, |bench, elapsed_s| {
            if elapsed_s > 0.5 {
                bench.robot.assembly.press_estop();
            }
        })
        .unwrap_err();
    assert!(
        matches!(
            error,
            MotionError::Refused(Refusal::State(StateRefusal::EmergencyStop { .. }))
        ),
        "{error}"
    );
    bench.tick();
    let stopped_at = bench.w2().0;
    bench.robot.assembly.release_estop();
    bench.robot.assembly.reset();
    bench.robot.assembly.enable(true);
    (0..200).for_each(|_| bench.tick());
    assert!(
        (bench.w2().0 - stopped_at).abs() < 0.03,
        "nobody moved it on"
    );
    bench.turn(0.0, |_, _| {}).unwrap();
}

#[test]
fn a_command_topic_that_froze_is_noticed() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let error = loop {
        match motion.step(bench.monitor.snapshot(), bench.now) {
            Ok(_) => bench.tick(), // The command is lost on its way.
            Err(error) => break error,
        }
    };
    assert!(matches!(error, MotionError::NotFollowing { .. }), "{error}");
    assert_eq!(bench.w2().0, 0.0);
}

#[test]
fn a_motion_outlasts_commands_that_are_lost_for_a_while() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let started = bench.now;
    let arrived = loop {
        let step = motion.step(bench.monitor.snapshot(), bench.now).unwrap();
        let measured_rad = bench.w2().0;
        match step {
            Step::Arrived(arrived) => break arrived,
            Step::Command(angles_rad) => {
                let ahead_rad = angles_rad[W2] - measured_rad;
                assert!(ahead_rad < 0.22, "{ahead_rad} rad ahead of the arm");
                let lost = (0.3..1.0).contains(&(bench.now - started).as_secs_f64());
                if !lost {
                    bench.obey(angles_rad);
                }
            }
        }
        bench.tick();
    };
    assert!((arrived.angle_rad - 1.5).abs() < 0.0087);
}

#[test]
fn a_blocked_joint_misses_its_deadline() {
    let mut bench = Bench::new();
    // So short a way that the following error stays within bounds.
    let mut motion = bench.start(0.1);
    let started = bench.now;
    let error = loop {
        match motion.step(bench.monitor.snapshot(), bench.now) {
            Ok(_) => bench.tick(),
            Err(error) => break error,
        }
    };
    assert!(matches!(error, MotionError::Deadline { .. }), "{error}");
    assert!(bench.now - started < Duration::from_secs(3));
    assert!(error.to_string().contains("left_w2"));
}

#[test]
fn a_stalled_commander_does_not_jump_ahead() {
    let mut bench = Bench::new();
    let mut motion = bench.start(1.5);
    let commanded = |step: Step| match step {
        Step::Command(angles_rad) => angles_rad[W2],
        Step::Arrived(_) => panic!("too early"),
    };
    let mut before = 0.0;
    for _ in 0..60 {
        before = commanded(motion.step(bench.monitor.snapshot(), bench.now).unwrap());
        let angles_rad = std::array::from_fn(|joint| if joint == W2 { before } else { 0.0 });
        bench.obey(angles_rad);
        bench.tick();
    }
    // 0.15 s pass in which nobody commands; the joint states remain fresh.
    (0..15).for_each(|_| bench.tick());
    let after = commanded(motion.step(bench.monitor.snapshot(), bench.now).unwrap());
    assert!(after - before <= 0.021, "jumped by {}", after - before);
}

#[test]
fn commands_are_bounded_in_velocity_even_with_an_uneven_ticker() {
    let bench = Bench::new();
    let mut motion = bench.start(1.5);
    let mut now = bench.now;
    let mut monitor = bench.monitor.clone();
    let names = Side::Left.joint_names().map(String::from);
    let mut previous = 0.0;
    for tick in 0..80_u32 {
        let pause = Duration::from_millis(if tick % 7 == 0 { 18 } else { 9 });
        now += pause;
        let state = monitor.snapshot().state.unwrap().value;
        monitor.state(state, now);
        let mut angles_rad = [0.0; 7];
        angles_rad[W2] = previous;
        monitor.joint_states(
            &names,
            &angles_rad,
            &[0.0; 7],
            bench.stamp + pause * tick,
            now,
        );
        let Step::Command(angles_rad) = motion.step(monitor.snapshot(), now).unwrap() else {
            panic!("too early");
        };
        assert!((angles_rad[W2] - previous) <= 1.0 * pause.as_secs_f64() + 1e-9);
        previous = angles_rad[W2];
    }
}
