//! The simulated robot and a motion on it, in simulated time.
#![allow(dead_code, missing_docs)] // Each test file uses a part.

use std::time::{Duration, Instant};

use baxter::{Side, W2};
use sim_baxter::{Kinematics, Robot};
use wrist_rotator::{Ended, Monitor, Motion, Parameters, Step, Turn};

pub const TICK: Duration = Duration::from_millis(10);
pub const TICK_S: f64 = 0.01;

/// A robot, what is known of it, and the time.
pub struct Bench {
    pub robot: Robot,
    pub monitor: Monitor,
    pub now: Instant,
    pub stamp: Duration,
    /// Topics that are silent.
    pub silent: Vec<&'static str>,
}

impl Bench {
    pub fn new() -> Self {
        let kinematics = Kinematics::baxter().unwrap();
        let mut parameters = sim_baxter::Parameters::default();
        parameters.scan_pose.left_arm_rad.left_w2 = 0.0;
        let mut monitor = Monitor::new(Side::Left);
        monitor.other_publishers(Some(vec![]));
        let mut bench = Self {
            robot: Robot::new(&parameters, &kinematics).unwrap(),
            monitor,
            now: Instant::now(),
            stamp: Duration::from_secs(1_000_000),
            silent: vec![],
        };
        bench.tick();
        bench
    }

    /// A hundredth of a second passes; the robot publishes.
    pub fn tick(&mut self) {
        self.robot.step(TICK_S);
        self.now += TICK;
        self.stamp += TICK;
        self.publish(self.now);
    }

    /// What the robot publishes reaches the monitor at `received`.
    pub fn publish(&mut self, received: Instant) {
        let speaks = |topic: &str| !self.silent.contains(&topic);
        if speaks("joint_states") {
            let states = self.robot.joint_states();
            let names: Vec<String> = states.names.iter().map(|name| name.to_string()).collect();
            let (positions, velocities) = (&states.positions, &states.velocities);
            self.monitor
                .joint_states(&names, positions, velocities, self.stamp, received);
        }
        if speaks("state") {
            self.monitor.state(self.robot.assembly.state(), received);
        }
        if speaks("cuff") {
            self.monitor
                .cuff(self.robot.cuff_held(Side::Left), received);
        }
        if speaks("collision_avoidance") {
            let objects = self.robot.collision_objects(Side::Left).to_vec();
            self.monitor.collision_objects(objects, received);
        }
        if speaks("collision_detection") {
            let impact = self.robot.impact(Side::Left);
            self.monitor.collision_detected(impact, received);
        }
    }

    pub fn start(&self, turn: impl Into<Turn>) -> Motion {
        let parameters = Parameters::default();
        Motion::start(&parameters, self.monitor.snapshot(), turn, self.now).unwrap()
    }

    pub fn obey(&mut self, angles_rad: [f64; 7]) {
        let names = Side::Left.joint_names().map(String::from);
        let _ = self.robot.command_arm(Side::Left, 1, &names, &angles_rad);
    }

    /// Carries the motion on to its end; `disturb` is called before each tick with the time since the start, s. Returns the
    /// end, and that time.
    pub fn carry_out(
        &mut self,
        motion: &mut Motion,
        mut disturb: impl FnMut(&mut Self, &mut Motion, f64),
    ) -> (Ended, f64) {
        let started = self.now;
        loop {
            let elapsed_s = (self.now - started).as_secs_f64();
            disturb(self, motion, elapsed_s);
            match motion.step(self.monitor.snapshot(), self.now) {
                Step::Ended(ended) => return (ended, elapsed_s),
                Step::Command(angles_rad) => {
                    self.monitor.commanded(angles_rad, self.now);
                    self.obey(angles_rad);
                }
                Step::Wait => {}
            }
            self.tick();
        }
    }

    /// Angle and velocity of W2, as they are.
    pub fn w2(&self) -> (f64, f64) {
        let arm = self.robot.arm(Side::Left);
        (arm.angles_rad()[W2], arm.velocities_rad_s()[W2])
    }

    /// What was done against the contract of motion. Half a second passes first, in which the last motion is judged.
    pub fn violations(&mut self) -> Vec<String> {
        (0..50).for_each(|_| self.tick());
        self.robot.take_violations()
    }
}
