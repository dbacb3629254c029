//! What the robot last said of itself, and when.

use std::time::{Duration, Instant};

use parameter::{JOINTS_PER_ARM, Side};

/// A value and the moment of its arrival.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aged<T> {
    /// Value.
    pub value: T,
    /// When it arrived, by this computer's clock.
    pub received: Instant,
}

/// The fields of `/robot/state`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotState {
    /// Fit to work; some firmware never says so.
    pub ready: bool,
    /// Joints are powered.
    pub enabled: bool,
    /// Stopped by button, software or fault.
    pub stopped: bool,
    /// A fault; not always fatal.
    pub error: bool,
    /// 0 unpressed, 1 pressed, 2 unknown, 3 released but not reset.
    pub estop_button: u8,
    /// 0 none, 1 user, 2 unknown, 3 fault, 4 brain.
    pub estop_source: u8,
}

/// One joint as `/robot/joint_states` last gave it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// Angle.
    pub angle_rad: f64,
    /// Velocity, where the message had one.
    pub velocity_rad_s: Option<f64>,
    /// The message's stamp, since the epoch of ROS time.
    pub stamp: Duration,
}

impl JointSample {
    /// What a joint_states message says of `joint`. Any layout will do: the joint is found by name, messages without it are
    /// normal, and lists shorter than that of the names lack the rest.
    pub fn find(
        joint: &str,
        names: &[String],
        positions: &[f64],
        velocities: &[f64],
        stamp: Duration,
    ) -> Option<Self> {
        let index = names.iter().position(|name| name == joint)?;
        Some(Self {
            angle_rad: *positions.get(index)?,
            velocity_rad_s: velocities.get(index).copied(),
            stamp,
        })
    }
}

/// All that decides whether the arm may move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Snapshot {
    /// `/robot/state`, if any came.
    pub state: Option<Aged<RobotState>>,
    /// The arm's joints in the robot's order, as far as they were heard of.
    pub joints: [Option<Aged<JointSample>>; JOINTS_PER_ARM],
    /// A person holds the cuff of this arm.
    pub cuff_held: bool,
    /// What collision avoidance sees too near.
    pub collision_objects: Vec<String>,
    /// Collision detection felt something.
    pub collision_detected: bool,
    /// Other nodes that publish on this arm's command topic; none while the master has not been asked.
    pub other_publishers: Option<Vec<String>>,
}

/// Gathers messages into a [`Snapshot`].
#[derive(Debug, Clone)]
pub struct Monitor {
    joint_names: [&'static str; JOINTS_PER_ARM],
    snapshot: Snapshot,
}

impl Monitor {
    /// Of one arm.
    pub fn new(side: Side) -> Self {
        Self {
            joint_names: side.joint_names(),
            snapshot: Snapshot::default(),
        }
    }

    /// What is known now.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// Takes a joint_states message, of this arm or of others.
    pub fn joint_states(
        &mut self,
        names: &[String],
        positions: &[f64],
        velocities: &[f64],
        stamp: Duration,
        now: Instant,
    ) {
        for (joint, name) in self.snapshot.joints.iter_mut().zip(self.joint_names) {
            let sample = JointSample::find(name, names, positions, velocities, stamp);
            if let Some(value) = sample {
                *joint = Some(Aged {
                    value,
                    received: now,
                });
            }
        }
    }

    /// Takes a `/robot/state` message.
    pub fn state(&mut self, value: RobotState, now: Instant) {
        self.snapshot.state = Some(Aged {
            value,
            received: now,
        });
    }

    /// Takes the cuff's state.
    pub fn cuff(&mut self, held: bool) {
        self.snapshot.cuff_held = held;
    }

    /// Takes what collision avoidance sees.
    pub fn collision_objects(&mut self, objects: Vec<String>) {
        self.snapshot.collision_objects = objects;
    }

    /// Takes what collision detection says.
    pub fn collision_detected(&mut self, detected: bool) {
        self.snapshot.collision_detected = detected;
    }

    /// Takes the master's answer: who else commands this arm. `None` where it gave none.
    pub fn other_publishers(&mut self, publishers: Option<Vec<String>>) {
        self.snapshot.other_publishers = publishers;
    }
}
