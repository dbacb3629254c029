//! Errors of a grasp.

use baxter::StateRefusal;

/// Why a grasp was refused or failed, with the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GraspError {
    /// No such command.
    #[error("'{0}' is no command; ask for open, close or width")]
    Command(String),
    /// A width that is not a positive number.
    #[error("width is {width_m} m; it must be a number above 0")]
    Width {
        /// The requested width, m.
        width_m: f64,
    },
    /// A width outside of this gripper's range.
    #[error("width is {width_m} m; this gripper's fingers go from {min_m} to {max_m} m")]
    WidthOutside {
        /// The requested width, m.
        width_m: f64,
        /// Distance of the closed fingers, m.
        min_m: f64,
        /// Distance of the open fingers, m.
        max_m: f64,
    },
    /// A force outside of 0 to 1.
    #[error(
        "force is {force}; it is a share of the gripper's largest, above 0 and up to 1, or 0 for the configured one"
    )]
    Force {
        /// The requested share of the largest force.
        force: f64,
    },
    /// Another grasp is running.
    #[error("the gripper is at work; wait for its end")]
    Busy,
    /// The robot's state forbids motion.
    #[error(transparent)]
    Robot(#[from] StateRefusal),
    /// No message from the gripper yet.
    #[error(
        "no message on {topic} yet: is the gripper plugged in, of this kind, and on this side?"
    )]
    Absent {
        /// Topic of its state.
        topic: String,
    },
    /// No fresh message from the gripper.
    #[error(
        "the gripper is silent: the last message on {topic} is {age_s:.2} s old (at most {max_s})"
    )]
    Silent {
        /// Topic of its state.
        topic: String,
        /// Age of its last message, s.
        age_s: f64,
        /// Allowed age, s.
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
    /// The gripper is not calibrated, and the parameters forbid calibration.
    #[error("the gripper is not calibrated: empty the hand and set calibrate to true")]
    NotCalibrated,
    /// Calibration ended in an error.
    #[error(
        "the gripper cannot be calibrated: it reports an error; is something between the fingers?"
    )]
    CalibrationFailed,
    /// Nobody subscribes to the commands.
    #[error(
        "nobody listens to {topic} (waited {waited_s:.1} s): is the gripper there, and can it reach this computer by its ROS_IP?"
    )]
    NobodyListens {
        /// Topic of the commands.
        topic: String,
        /// How long the node has waited, s.
        waited_s: f64,
    },
    /// A command that the gripper did not acknowledge.
    #[error(
        "the gripper did not acknowledge '{command}' within {patience_s} s: does another node command it?"
    )]
    NotAcknowledged {
        /// The command.
        command: &'static str,
        /// Time limit, s.
        patience_s: f64,
    },
    /// A command that did not end in time.
    #[error(
        "the gripper took '{command}' but did not end it within {patience_s} s; the fingers are {width_m:.4} m apart"
    )]
    NotEnded {
        /// The command.
        command: &'static str,
        /// Time limit, s.
        patience_s: f64,
        /// Distance of the fingers, m.
        width_m: f64,
    },
    /// A finger is not where it was commanded, although it carries no load.
    #[error(
        "finger f{finger} is at {measured_rad:.2} rad when {commanded_rad:.2} was commanded, and no load says why: does \
         the hand's driver listen, is the finger's tendon whole?"
    )]
    NotFollowing {
        /// Number of the finger, from 1.
        finger: usize,
        /// Measured angle, rad.
        measured_rad: f64,
        /// Commanded angle, rad.
        commanded_rad: f64,
    },
    /// Only one finger touches something, so the object is not held.
    #[error(
        "only finger f{finger} meets something: it is not held; is it off the middle of the hand?"
    )]
    OneFinger {
        /// Number of the finger, from 1.
        finger: usize,
    },
    /// The fingers did not come to rest in time.
    #[error("the fingers did not come to rest within {patience_s} s")]
    Restless {
        /// Time limit, s.
        patience_s: f64,
    },
    /// The caller has closed its connection.
    #[error("the caller has gone; the fingers were stopped")]
    CallerGone,
    /// The node is shutting down.
    #[error("the gripper node is shutting down; the fingers were stopped")]
    Shutdown,
}
