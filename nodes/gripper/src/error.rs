//! Why a grasp was refused, or failed.

use baxter::StateRefusal;

/// What is wrong, and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GraspError {
    /// No such command.
    #[error("'{0}' is no command; ask for open, close or width")]
    Command(String),
    /// A width that no hand has.
    #[error("width is {width_m} m; it must be a number above 0")]
    Width {
        /// What was asked.
        width_m: f64,
    },
    /// A width that this gripper does not have.
    #[error("width is {width_m} m; this gripper's fingers go from {min_m} to {max_m} m")]
    WidthOutside {
        /// What was asked.
        width_m: f64,
        /// Closed.
        min_m: f64,
        /// Open.
        max_m: f64,
    },
    /// A force that is no share.
    #[error(
        "force is {force}; it is a share of the gripper's largest, above 0 and up to 1, or 0 for the configured one"
    )]
    Force {
        /// What was asked.
        force: f64,
    },
    /// One task at a time.
    #[error("the gripper is at work; wait for its end")]
    Busy,
    /// The robot's state forbids it.
    #[error(transparent)]
    Robot(#[from] StateRefusal),
    /// Nothing was ever heard of the gripper.
    #[error(
        "no message on {topic} yet: is the gripper plugged in, of this kind, and on this side?"
    )]
    Absent {
        /// Where it would speak.
        topic: String,
    },
    /// The gripper has fallen silent.
    #[error(
        "the gripper is silent: the last message on {topic} is {age_s:.2} s old (at most {max_s})"
    )]
    Silent {
        /// Where it speaks.
        topic: String,
        /// Age of its last message.
        age_s: f64,
        /// Allowed age.
        max_s: f64,
    },
    /// Another kind of gripper is plugged in.
    #[error("the gripper is {0}, not an electric one: set ~hand and ~side to what is mounted")]
    OtherKind(&'static str),
    /// The gripper has no power.
    #[error(
        "the gripper is not enabled: enable the robot, and look whether the gripper's cable is in"
    )]
    NotEnabled,
    /// It does not know its travel, and must not find out.
    #[error("the gripper is not calibrated: empty the hand and set calibrate to true")]
    NotCalibrated,
    /// Calibration ended in an error.
    #[error(
        "the gripper cannot be calibrated: it reports an error; is something between the fingers?"
    )]
    CalibrationFailed,
    /// Commands would be lost.
    #[error(
        "nobody listens to {topic} (waited {waited_s:.1} s): is the gripper there, and can it reach this computer by its ROS_IP?"
    )]
    NobodyListens {
        /// Topic of the commands.
        topic: String,
        /// How long it was waited for.
        waited_s: f64,
    },
    /// A command that the gripper did not take.
    #[error(
        "the gripper did not acknowledge '{command}' within {patience_s} s: does another node command it?"
    )]
    NotAcknowledged {
        /// The command.
        command: &'static str,
        /// How long it was waited for.
        patience_s: f64,
    },
    /// A command that did not come to its end.
    #[error(
        "the gripper took '{command}' but did not end it within {patience_s} s; the fingers are {width_m:.4} m apart"
    )]
    NotEnded {
        /// The command.
        command: &'static str,
        /// How long it was waited for.
        patience_s: f64,
        /// Distance of the fingers.
        width_m: f64,
    },
    /// A finger is elsewhere than it was told, and nothing presses on it.
    #[error(
        "finger f{finger} is at {measured_rad:.2} rad when {commanded_rad:.2} was commanded, and no load says why: does \
         the hand's driver listen, is the finger's tendon whole?"
    )]
    NotFollowing {
        /// Its number, from 1.
        finger: usize,
        /// Where it is.
        measured_rad: f64,
        /// Where it should be.
        commanded_rad: f64,
    },
    /// One finger alone holds nothing.
    #[error(
        "only finger f{finger} meets something: it is not held; is it off the middle of the hand?"
    )]
    OneFinger {
        /// Its number, from 1.
        finger: usize,
    },
    /// The hand was not at rest in time.
    #[error("the fingers did not come to rest within {patience_s} s")]
    Restless {
        /// How long it was waited for.
        patience_s: f64,
    },
    /// Whoever asked is gone.
    #[error("the caller has gone; the fingers were stopped")]
    CallerGone,
    /// The node was told to end.
    #[error("the gripper node is shutting down; the fingers were stopped")]
    Shutdown,
}
