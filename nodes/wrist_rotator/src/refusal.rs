//! Why the arm must not move, each case with its remedy.

use baxter::{Silence, StateRefusal};

use crate::parameters::Surroundings;

/// Lower limit of the requested rate of a turn, rad/s. The measured velocity of a slower joint cannot be distinguished from noise
/// at rest.
pub(crate) const RATE_MIN_RAD_S: f64 = 0.05;

/// Why the arm must not move.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The robot's state forbids it.
    #[error(transparent)]
    State(#[from] StateRefusal),
    /// Some joints were never heard of.
    #[error("no angle of {} on /robot/joint_states yet: is this the right side and robot?", .joints.join(", "))]
    JointsAbsent {
        /// Their names.
        joints: Vec<&'static str>,
    },
    /// The newest angle of a joint is too old.
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
    /// The arm has not come to rest: where it would be held is not known.
    #[error("{joint} still moves at {velocity_rad_s:.2} rad/s: ask again when the arm rests")]
    StillMoving {
        /// Joint.
        joint: &'static str,
        /// Its velocity.
        velocity_rad_s: f64,
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
    /// Rate at which the wrist must not, or cannot, turn.
    #[error(
        "rate is {rate_rad_s} rad/s: allowed are {RATE_MIN_RAD_S} to {max_rad_s} (velocity_max_rad_s, which the robot's \
         speed ratio limits)"
    )]
    RateOutOfRange {
        /// Asked rate.
        rate_rad_s: f64,
        /// Largest rate.
        max_rad_s: f64,
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
    /// No message came on a topic that can forbid motion, such as the emergency stop, or the last one is too old.
    #[error(
        "{}: is the robot's driver up? Where the robot has no such topic, as in a simulator, name {} in ~waived",
        silence_of(.topic, *.silence), .what.name()
    )]
    Unheard {
        /// What is missing.
        what: Surroundings,
        /// Where it would be heard.
        topic: String,
        /// Whether it was ever heard.
        silence: Silence,
    },
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

impl Refusal {
    /// Whether a message is missing or too old: the next one may come any moment.
    pub fn is_of_silence(&self) -> bool {
        matches!(
            self,
            Self::State(StateRefusal::Absent | StateRefusal::Stale { .. })
                | Self::JointsAbsent { .. }
                | Self::JointsStale { .. }
                | Self::Unheard { .. }
        )
    }
}

fn silence_of(topic: &str, silence: Silence) -> String {
    match silence {
        Silence::Never => format!("no message on {topic} yet"),
        Silence::Stale { age_s, max_s } => {
            format!("last message on {topic} is {age_s:.2} s old (at most {max_s})")
        }
    }
}
