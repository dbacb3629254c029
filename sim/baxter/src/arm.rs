//! One arm: what it accepts, how long it obeys, how it moves.

use std::collections::VecDeque;

use baxter::JOINTS_PER_ARM;

use crate::contract::Setpoint;
use crate::parameters::Parameters;
use crate::tracker::{Goal, Tracker};
use crate::urdf::Limits;

/// Longest silence that a client may ask the arm to bear, seconds.
const COMMAND_TIMEOUT_MAX_S: f64 = 1.0;

/// What the numbers of a joint command mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandMode {
    /// Angles, approached at the speed ratio.
    Position,
    /// Angular velocities.
    Velocity,
    /// Angles, approached at full speed.
    RawPosition,
}

/// Why a joint command is not obeyed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CommandError {
    /// The robot is not enabled.
    #[error("joint command ignored: the robot is not enabled")]
    NotEnabled,
    /// Somebody guides the arm by its cuff.
    #[error("joint command ignored: the cuff is held")]
    CuffHeld,
    /// Torque mode or nonsense.
    #[error(
        "joint command refused: mode {0} is none of 1 (position), 2 (velocity), 4 (raw position)"
    )]
    Mode(i32),
    /// Not one number for each name.
    #[error("joint command refused: {names} names, {values} numbers")]
    UnequalLengths {
        /// Count of names.
        names: usize,
        /// Count of numbers.
        values: usize,
    },
    /// Not a joint of this arm.
    #[error("joint command refused: this arm has no joint `{0}`")]
    UnknownJoint(String),
    /// The same joint twice.
    #[error("joint command refused: joint `{0}` is named twice")]
    NamedTwice(String),
    /// NaN or infinity.
    #[error("joint command refused: joint `{joint}` is told {value}")]
    NotFinite {
        /// Joint.
        joint: String,
        /// Number.
        value: f64,
    },
}

/// A seven-joint arm. Angles in rad, in the order s0, s1, e0, e1, w0, w1, w2.
#[derive(Debug, Clone)]
pub struct Arm {
    names: [&'static str; JOINTS_PER_ARM],
    joints: [Tracker; JOINTS_PER_ARM],
    goals: [Goal; JOINTS_PER_ARM],
    /// Accepted commands that the controller has not seen yet, and when it will.
    on_the_way: VecDeque<(f64, CommandMode, Setpoint)>,
    time_s: f64,
    silent_s: f64,
    speed_ratio: f64,
    command_timeout_s: f64,
    command_delay_s: f64,
}

impl Arm {
    pub(crate) fn new(
        names: [&'static str; JOINTS_PER_ARM],
        limits: [Limits; JOINTS_PER_ARM],
        angles_rad: [f64; JOINTS_PER_ARM],
        parameters: &Parameters,
    ) -> Self {
        let joint = |index: usize| {
            let acceleration_max = match index {
                0..4 => parameters.acceleration_max_upper_arm_rad_s2,
                _ => parameters.acceleration_max_wrist_rad_s2,
            };
            Tracker::new(angles_rad[index], limits[index], acceleration_max)
        };
        Self {
            names,
            joints: std::array::from_fn(joint),
            goals: [Goal::Hold; JOINTS_PER_ARM],
            on_the_way: VecDeque::new(),
            time_s: 0.0,
            silent_s: 0.0,
            speed_ratio: parameters.speed_ratio,
            command_timeout_s: parameters.command_timeout_s,
            command_delay_s: parameters.command_delay_s,
        }
    }

    /// Joint names in the robot's order.
    pub fn names(&self) -> [&'static str; JOINTS_PER_ARM] {
        self.names
    }

    /// True angles without encoder noise, rad.
    pub fn angles_rad(&self) -> [f64; JOINTS_PER_ARM] {
        self.joints.each_ref().map(|joint| joint.position)
    }

    /// True velocities, rad/s.
    pub fn velocities_rad_s(&self) -> [f64; JOINTS_PER_ARM] {
        self.joints.each_ref().map(|joint| joint.velocity)
    }

    /// Where the joints are told to go, rad; `None` for those that hold.
    pub fn position_goals_rad(&self) -> [Option<f64>; JOINTS_PER_ARM] {
        self.goals.map(|goal| match goal {
            Goal::Position { target, .. } => Some(target),
            Goal::Hold | Goal::Velocity(_) => None,
        })
    }

    /// Fraction of the velocity limits used in position mode.
    pub fn speed_ratio(&self) -> f64 {
        self.speed_ratio
    }

    /// Sets the fraction, clipped to 0..1; it stays until set again, whoever commands. NaN is ignored.
    pub fn set_speed_ratio(&mut self, speed_ratio: f64) {
        if !speed_ratio.is_nan() {
            self.speed_ratio = speed_ratio.clamp(0.0, 1.0);
        }
    }

    /// Sets the silence after which the arm holds, clipped to 0..1 s. NaN is ignored.
    pub fn set_command_timeout(&mut self, command_timeout_s: f64) {
        if !command_timeout_s.is_nan() {
            self.command_timeout_s = command_timeout_s.clamp(0.0, COMMAND_TIMEOUT_MAX_S);
        }
    }

    /// Accepts a command for all or some joints, as `JointCommand` brings it.
    pub(crate) fn command(
        &mut self,
        mode: i32,
        names: &[String],
        values: &[f64],
    ) -> Result<(), CommandError> {
        let mode = match mode {
            1 => CommandMode::Position,
            2 => CommandMode::Velocity,
            4 => CommandMode::RawPosition,
            other => return Err(CommandError::Mode(other)),
        };
        let goals = self.read_goals(names, values)?;
        self.on_the_way
            .push_back((self.time_s + self.command_delay_s, mode, goals));
        self.silent_s = 0.0;
        Ok(())
    }

    /// The angles of a command in one of the position modes, if it is well formed.
    pub(crate) fn setpoint(&self, mode: i32, names: &[String], values: &[f64]) -> Option<Setpoint> {
        matches!(mode, 1 | 4)
            .then(|| self.read_goals(names, values).ok())
            .flatten()
    }

    /// Blocks a joint where it is, or lets it free.
    pub fn jam(&mut self, joint: usize, jammed: bool) {
        if let Some(joint) = self.joints.get_mut(joint) {
            joint.jammed = jammed;
        }
    }

    /// Forgets all commands; the joints brake and stay.
    pub(crate) fn hold(&mut self) {
        self.on_the_way.clear();
        self.goals = [Goal::Hold; JOINTS_PER_ARM];
    }

    pub(crate) fn step(&mut self, dt_s: f64) {
        self.time_s += dt_s;
        self.silent_s += dt_s;
        self.take_due_commands();
        if self.silent_s > self.command_timeout_s {
            self.hold();
        }
        for (joint, goal) in self.joints.iter_mut().zip(self.goals) {
            joint.step(goal, dt_s);
        }
    }

    fn read_goals(&self, names: &[String], values: &[f64]) -> Result<Setpoint, CommandError> {
        if names.len() != values.len() {
            let (names, values) = (names.len(), values.len());
            return Err(CommandError::UnequalLengths { names, values });
        }
        let mut goals = Setpoint::default();
        for (name, &value) in names.iter().zip(values) {
            let index = self.names.iter().position(|own| own == name);
            let index = index.ok_or_else(|| CommandError::UnknownJoint(name.clone()))?;
            if !value.is_finite() {
                return Err(CommandError::NotFinite {
                    joint: name.clone(),
                    value,
                });
            }
            if goals[index].replace(value).is_some() {
                return Err(CommandError::NamedTwice(name.clone()));
            }
        }
        Ok(goals)
    }

    fn take_due_commands(&mut self) {
        while let Some((due_s, mode, goals)) = self.on_the_way.front().copied() {
            if due_s > self.time_s {
                return;
            }
            self.on_the_way.pop_front();
            for (goal, value) in self.goals.iter_mut().zip(goals) {
                let Some(value) = value else { continue };
                *goal = match mode {
                    CommandMode::Position => Goal::Position {
                        target: value,
                        speed: self.speed_ratio,
                    },
                    CommandMode::RawPosition => Goal::Position {
                        target: value,
                        speed: 1.0,
                    },
                    CommandMode::Velocity => Goal::Velocity(value),
                };
            }
        }
    }
}
