//! How a motion ended, and why.

use std::time::Duration;

use baxter::Arrived;

use crate::refusal::Refusal;
use crate::setpoints::NoPath;

/// The part of a turn in which the commanded rate is constant, by the stamps of the joint states that were the newest then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConstantPart {
    /// When it began, ROS time.
    pub from: Duration,
    /// When it ended, ROS time.
    pub until: Duration,
}

/// The end of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// At the target, or why not.
    pub result: Result<Arrived, MotionError>,
    /// Where and since when the arm rests; `None` where it was not seen at rest within 2 s.
    pub rest: Option<Arrived>,
    /// The last part at a constant rate that nothing interrupted; `None` where the rate was never reached.
    pub constant: Option<ConstantPart>,
}

/// Why a motion ended before its target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A rule forbids to go on.
    #[error("motion stopped: {0}")]
    Refused(#[from] Refusal),
    /// Something is not heard, or was not listened to.
    #[error(
        "motion stopped: {refusal}; this computer did not get to run for {stalled_s:.2} s: it is too busy"
    )]
    Stalled {
        /// What is old.
        refusal: Refusal,
        /// Time between two ticks, s.
        stalled_s: f64,
    },
    /// The arm is elsewhere than it was told.
    #[error(
        "motion stopped: {joint} is at {measured_rad:.3} rad when {commanded_rad:.3} was commanded, and has been \
         no nearer for {lagging_s:.1} s: the arm is blocked, slower than the speed ratio asked for, or does not \
         receive its commands"
    )]
    NotFollowing {
        /// Joint.
        joint: &'static str,
        /// Where it is.
        measured_rad: f64,
        /// Where it should be.
        commanded_rad: f64,
        /// How long it has been too far behind.
        lagging_s: f64,
    },
    /// Too late.
    #[error(
        "motion stopped: {joint} is not at rest at {target_rad:.3} rad after {after_s:.1} s; it is at \
         {measured_rad:.3} rad"
    )]
    Deadline {
        /// Joint.
        joint: &'static str,
        /// Where it should be.
        target_rad: f64,
        /// Where it is.
        measured_rad: f64,
        /// Time since the start.
        after_s: f64,
    },
    /// Somebody called `stop_wrist`.
    #[error("motion stopped: stop_wrist was called")]
    Stopped,
    /// Whoever asked no longer waits; in words.
    #[error("motion stopped: {0}")]
    NobodyWaits(String),
    /// The generator of setpoints failed.
    #[error("motion stopped: {0}")]
    NoPath(#[from] NoPath),
}
