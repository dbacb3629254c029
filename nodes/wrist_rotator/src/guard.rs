//! When the arm must not move, each case with its name and its remedy.

use std::time::{Duration, Instant};

use crate::monitor::{RobotState, Snapshot};
use crate::parameters::Parameters;
use parameter::JOINTS_PER_ARM;

const ESTOP_BUTTONS: [&str; 4] = ["unpressed", "pressed", "unknown", "released"];
const ESTOP_SOURCES: [&str; 5] = ["none", "user", "unknown", "fault", "brain"];

/// Why the arm must not move.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// No `/robot/state` at all.
    #[error("no message on /robot/state yet: is the robot on, and ROS_MASTER_URI its own?")]
    StateAbsent,
    /// `/robot/state` has ceased.
    #[error(
        "last message on /robot/state is {age_s:.2} s old (at most {max_s}): check the link to the robot"
    )]
    StateStale {
        /// Its age.
        age_s: f64,
        /// Allowed age.
        max_s: f64,
    },
    /// Button or another source of emergency stop.
    #[error(
        "emergency stop: button {button}, source {source_name}: release the button, reset and enable the robot"
    )]
    EmergencyStop {
        /// State of the button.
        button: String,
        /// What caused it.
        source_name: String,
    },
    /// Stopped without emergency stop.
    #[error("the robot is stopped: reset and enable it")]
    Stopped,
    /// Fault reported.
    #[error("the robot reports an error: reset and enable it, or allow it by tolerate_error")]
    Error,
    /// Not enabled.
    #[error("the robot is not enabled: enable it (rosrun baxter_tools enable_robot.py -e)")]
    NotEnabled,
    /// Not ready, where readiness is asked for.
    #[error(
        "the robot does not say that it is ready: wait for homing, or set require_ready to false"
    )]
    NotReady,
    /// Some joints were never heard of.
    #[error("no angle of {} on /robot/joint_states yet: is this the right side and robot?", .joints.join(", "))]
    JointsAbsent {
        /// Their names.
        joints: Vec<&'static str>,
    },
    /// Joint angles have ceased.
    #[error(
        "last angle of {joint} is {age_s:.2} s old (at most {max_s}): check the link to the robot"
    )]
    JointsStale {
        /// Oldest joint.
        joint: &'static str,
        /// Its age.
        age_s: f64,
        /// Allowed age.
        max_s: f64,
    },
    /// A joint angle is NaN or infinite.
    #[error("the robot reports {angle_rad} rad for {joint}: the encoder or its message is broken")]
    JointNotFinite {
        /// Joint.
        joint: &'static str,
        /// What was reported.
        angle_rad: f64,
    },
    /// NaN or infinite target.
    #[error("target is {angle_rad} rad: ask for a finite angle")]
    TargetNotFinite {
        /// Asked angle.
        angle_rad: f64,
    },
    /// Target out of range.
    #[error("target is {angle_rad} rad: allowed are {min_rad} to {max_rad}")]
    TargetOutsideLimits {
        /// Asked angle.
        angle_rad: f64,
        /// Lower limit.
        min_rad: f64,
        /// Upper limit.
        max_rad: f64,
    },
    /// Somebody else commands the arm.
    #[error("{} also publishes joint commands for this arm: stop it first", .nodes.join(", "))]
    OtherPublisher {
        /// Names of the nodes.
        nodes: Vec<String>,
    },
    /// The master did not say who commands the arm.
    #[error("the master did not say who else commands this arm: check that it is alive")]
    PublishersUnknown,
    /// A person guides the arm.
    #[error("the cuff of the arm is held: let it go")]
    CuffHeld,
    /// Collision avoidance or detection.
    #[error("collision reported ({what}): clear the way")]
    Collision {
        /// What is too near.
        what: String,
    },
}

/// The rules by which motion is refused.
#[derive(Debug, Clone)]
pub struct Guard {
    joint_names: [&'static str; JOINTS_PER_ARM],
    state_age_max: Duration,
    joints_age_max: Duration,
    angle_min_rad: f64,
    angle_max_rad: f64,
    require_ready: bool,
    tolerate_error: bool,
}

impl Guard {
    /// With the ages, limits and policies of `parameters`.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            joint_names: parameters.side.joint_names(),
            state_age_max: Duration::from_secs_f64(parameters.state_age_max_s),
            joints_age_max: Duration::from_secs_f64(parameters.joints_age_max_s),
            angle_min_rad: parameters.angle_min_rad,
            angle_max_rad: parameters.angle_max_rad,
            require_ready: parameters.require_ready,
            tolerate_error: parameters.tolerate_error,
        }
    }

    /// May a motion to `target_rad` start? Then these are the angles to start from, rad, in the robot's order.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn check_start(
        &self,
        snapshot: &Snapshot,
        target_rad: f64,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        self.check_target(target_rad)?;
        let angles_rad = self.check(snapshot, now)?;
        if snapshot.other_publishers.is_none() {
            return Err(Refusal::PublishersUnknown);
        }
        Ok(angles_rad)
    }

    /// May a motion go on? Then these are the measured angles, rad, in the robot's order. A master that does not answer is
    /// no reason to stop: it takes no part in the motion.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn check(
        &self,
        snapshot: &Snapshot,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        self.check_state(snapshot, now)?;
        let angles_rad = self.check_joints(snapshot, now)?;
        check_surroundings(snapshot)?;
        Ok(angles_rad)
    }

    fn check_target(&self, angle_rad: f64) -> Result<(), Refusal> {
        if !angle_rad.is_finite() {
            return Err(Refusal::TargetNotFinite { angle_rad });
        }
        let (min_rad, max_rad) = (self.angle_min_rad, self.angle_max_rad);
        if angle_rad < min_rad || angle_rad > max_rad {
            return Err(Refusal::TargetOutsideLimits {
                angle_rad,
                min_rad,
                max_rad,
            });
        }
        Ok(())
    }

    fn check_state(&self, snapshot: &Snapshot, now: Instant) -> Result<(), Refusal> {
        let state = snapshot.state.ok_or(Refusal::StateAbsent)?;
        let age = now.saturating_duration_since(state.received);
        if age > self.state_age_max {
            let (age_s, max_s) = (age.as_secs_f64(), self.state_age_max.as_secs_f64());
            return Err(Refusal::StateStale { age_s, max_s });
        }
        // The cause before its consequences: an emergency stop also stops and disables.
        match state.value {
            RobotState {
                estop_button: 1.., ..
            }
            | RobotState {
                estop_source: 1.., ..
            } => Err(emergency_stop(state.value)),
            RobotState { stopped: true, .. } => Err(Refusal::Stopped),
            RobotState { error: true, .. } if !self.tolerate_error => Err(Refusal::Error),
            RobotState { enabled: false, .. } => Err(Refusal::NotEnabled),
            RobotState { ready: false, .. } if self.require_ready => Err(Refusal::NotReady),
            _ => Ok(()),
        }
    }

    fn check_joints(
        &self,
        snapshot: &Snapshot,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        let mut angles_rad = [0.0; JOINTS_PER_ARM];
        let named = || self.joint_names.into_iter().zip(&snapshot.joints);
        let absent = |(name, sample): (&'static str, &Option<_>)| sample.is_none().then_some(name);
        let joints: Vec<_> = named().filter_map(absent).collect();
        if !joints.is_empty() {
            return Err(Refusal::JointsAbsent { joints });
        }
        for (angle, (joint, sample)) in angles_rad.iter_mut().zip(named()) {
            let Some(sample) = sample else { continue };
            let age = now.saturating_duration_since(sample.received);
            if age > self.joints_age_max {
                let (age_s, max_s) = (age.as_secs_f64(), self.joints_age_max.as_secs_f64());
                return Err(Refusal::JointsStale {
                    joint,
                    age_s,
                    max_s,
                });
            }
            let angle_rad = sample.value.angle_rad;
            if !angle_rad.is_finite() {
                return Err(Refusal::JointNotFinite { joint, angle_rad });
            }
            *angle = angle_rad;
        }
        Ok(angles_rad)
    }
}

fn check_surroundings(snapshot: &Snapshot) -> Result<(), Refusal> {
    if let Some(nodes) = snapshot
        .other_publishers
        .as_ref()
        .filter(|nodes| !nodes.is_empty())
    {
        return Err(Refusal::OtherPublisher {
            nodes: nodes.clone(),
        });
    }
    if snapshot.cuff_held {
        return Err(Refusal::CuffHeld);
    }
    if !snapshot.collision_objects.is_empty() {
        return Err(Refusal::Collision {
            what: snapshot.collision_objects.join(", "),
        });
    }
    if snapshot.collision_detected {
        return Err(Refusal::Collision {
            what: "impact detected".to_owned(),
        });
    }
    Ok(())
}

fn emergency_stop(state: RobotState) -> Refusal {
    let name = |names: &[&str], value: u8| {
        names
            .get(usize::from(value))
            .map_or(value.to_string(), |name| name.to_string())
    };
    Refusal::EmergencyStop {
        button: name(&ESTOP_BUTTONS, state.estop_button),
        source_name: name(&ESTOP_SOURCES, state.estop_source),
    }
}
