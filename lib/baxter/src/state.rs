//! The robot's state on `/robot/state`, and which states forbid motion.

use std::fmt::{Display, Formatter};
use std::time::{Duration, Instant};

use crate::aged::{Aged, Silence, fresh};

/// The fields of `/robot/state` (`baxter_core_msgs/AssemblyState`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotState {
    /// Ready to work; always false with firmware 1.1 and with the maker's emulator.
    pub ready: bool,
    /// Joints are powered.
    pub enabled: bool,
    /// Stopped by button, software or fault.
    pub stopped: bool,
    /// A fault; not always fatal.
    pub error: bool,
    /// Position of the emergency stop button.
    pub estop_button: EstopButton,
    /// What stopped the robot.
    pub estop_source: EstopSource,
}

/// Position of the emergency stop button.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EstopButton {
    /// At rest.
    Unpressed,
    /// Held down.
    Pressed,
    /// Stopped by software.
    Unknown,
    /// Let go, but the robot has not been reset since.
    Released,
    /// A number that the message's definition does not have.
    Other(u8),
}

/// What stopped the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EstopSource {
    /// Nothing.
    None,
    /// A person, by the button.
    User,
    /// Not known, as after a stop by software.
    Unknown,
    /// A fault of a part.
    Fault,
    /// A fault of the main computer.
    Brain,
    /// A number that the message's definition does not have.
    Other(u8),
}

impl RobotState {
    /// Enabled and well.
    pub const HEALTHY: Self = Self {
        ready: true,
        enabled: true,
        stopped: false,
        error: false,
        estop_button: EstopButton::Unpressed,
        estop_source: EstopSource::None,
    };
}

impl From<u8> for EstopButton {
    fn from(number: u8) -> Self {
        match number {
            0 => Self::Unpressed,
            1 => Self::Pressed,
            2 => Self::Unknown,
            3 => Self::Released,
            other => Self::Other(other),
        }
    }
}

impl From<EstopButton> for u8 {
    fn from(button: EstopButton) -> Self {
        match button {
            EstopButton::Unpressed => 0,
            EstopButton::Pressed => 1,
            EstopButton::Unknown => 2,
            EstopButton::Released => 3,
            EstopButton::Other(number) => number,
        }
    }
}

impl Display for EstopButton {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unpressed => formatter.write_str("unpressed"),
            Self::Pressed => formatter.write_str("pressed"),
            Self::Unknown => formatter.write_str("unknown"),
            Self::Released => formatter.write_str("released"),
            Self::Other(number) => number.fmt(formatter),
        }
    }
}

impl From<u8> for EstopSource {
    fn from(number: u8) -> Self {
        match number {
            0 => Self::None,
            1 => Self::User,
            2 => Self::Unknown,
            3 => Self::Fault,
            4 => Self::Brain,
            other => Self::Other(other),
        }
    }
}

impl From<EstopSource> for u8 {
    fn from(source: EstopSource) -> Self {
        match source {
            EstopSource::None => 0,
            EstopSource::User => 1,
            EstopSource::Unknown => 2,
            EstopSource::Fault => 3,
            EstopSource::Brain => 4,
            EstopSource::Other(number) => number,
        }
    }
}

impl Display for EstopSource {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => formatter.write_str("none"),
            Self::User => formatter.write_str("user"),
            Self::Unknown => formatter.write_str("unknown"),
            Self::Fault => formatter.write_str("fault"),
            Self::Brain => formatter.write_str("brain"),
            Self::Other(number) => number.fmt(formatter),
        }
    }
}

/// Which states forbid motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StateRules {
    /// Age at which `/robot/state` no longer counts.
    pub age_max: Duration,
    /// Whether motion requires that the robot reports `ready`.
    pub require_ready: bool,
    /// Whether motion is allowed although the robot reports an error.
    pub tolerate_error: bool,
}

/// Why the robot's state forbids motion, with the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StateRefusal {
    /// No message on `/robot/state` yet.
    #[error("no message on /robot/state yet: is the robot on, and ROS_MASTER_URI its own?")]
    Absent,
    /// No fresh message on `/robot/state`.
    #[error(
        "last message on /robot/state is {age_s:.2} s old (at most {max_s}): check the link to the robot"
    )]
    Stale {
        /// Its age, s.
        age_s: f64,
        /// Allowed age, s.
        max_s: f64,
    },
    /// Emergency stop, by the button or another source.
    #[error(
        "the robot is stopped by emergency stop (button {button}, source {source_name}): release the button, reset and \
         enable the robot"
    )]
    EmergencyStop {
        /// State of the button.
        button: EstopButton,
        /// What caused it.
        source_name: EstopSource,
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
}

impl StateRules {
    /// Checks whether the robot may move, by its `last` state.
    ///
    /// # Errors
    /// Why not. The cause is named before its consequences, since an emergency stop also stops and disables.
    pub fn check(&self, last: Option<&Aged<RobotState>>, now: Instant) -> Result<(), StateRefusal> {
        let state = fresh(last, self.age_max, now).map_err(|silence| match silence {
            Silence::Never => StateRefusal::Absent,
            Silence::Stale { age_s, max_s } => StateRefusal::Stale { age_s, max_s },
        })?;
        let (button, source_name) = (state.estop_button, state.estop_source);
        if button != EstopButton::Unpressed || source_name != EstopSource::None {
            return Err(StateRefusal::EmergencyStop {
                button,
                source_name,
            });
        }
        match state {
            RobotState { stopped: true, .. } => Err(StateRefusal::Stopped),
            RobotState { error: true, .. } if !self.tolerate_error => Err(StateRefusal::Error),
            RobotState { enabled: false, .. } => Err(StateRefusal::NotEnabled),
            RobotState { ready: false, .. } if self.require_ready => Err(StateRefusal::NotReady),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
