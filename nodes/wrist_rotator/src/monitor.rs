//! What the robot last said of itself, and when.

use std::time::{Duration, Instant};

use baxter::{Aged, JOINTS_PER_ARM, JointSample, RobotState, Side};

/// All that decides whether the arm may move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Snapshot {
    /// `/robot/state`, if any came.
    pub state: Option<Aged<RobotState>>,
    /// The arm's joints in the robot's order, as far as they were heard of.
    pub joints: [Option<Aged<JointSample>>; JOINTS_PER_ARM],
    /// Whether a person holds the cuff of this arm, if the robot said so.
    pub cuff_held: Option<Aged<bool>>,
    /// What collision avoidance sees too near, if it said anything.
    pub collision_objects: Option<Aged<Vec<String>>>,
    /// Whether collision detection feels something, if it said so.
    pub collision_detected: Option<Aged<bool>>,
    /// What this node last told the arm, rad, in the robot's order.
    pub commanded: Option<Aged<[f64; JOINTS_PER_ARM]>>,
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
            if let Some(sample) = sample {
                *joint = Some(Aged::new(sample, now));
            }
        }
    }

    /// Takes a `/robot/state` message.
    pub fn state(&mut self, value: RobotState, received: Instant) {
        self.snapshot.state = Some(Aged { value, received });
    }

    /// Takes the cuff's state.
    pub fn cuff(&mut self, value: bool, received: Instant) {
        self.snapshot.cuff_held = Some(Aged { value, received });
    }

    /// Takes what collision avoidance sees.
    pub fn collision_objects(&mut self, value: Vec<String>, received: Instant) {
        self.snapshot.collision_objects = Some(Aged { value, received });
    }

    /// Takes what collision detection says.
    pub fn collision_detected(&mut self, value: bool, received: Instant) {
        self.snapshot.collision_detected = Some(Aged { value, received });
    }

    /// Takes a command as it goes out.
    pub fn commanded(&mut self, value: [f64; JOINTS_PER_ARM], received: Instant) {
        self.snapshot.commanded = Some(Aged { value, received });
    }

    /// Takes the master's answer: who else commands this arm. `None` where it gave none.
    pub fn other_publishers(&mut self, publishers: Option<Vec<String>>) {
        self.snapshot.other_publishers = publishers;
    }
}
