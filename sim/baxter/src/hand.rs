//! What is mounted on a wrist.

use serde::{Deserialize, Serialize};

use crate::gripper::Gripper;
use crate::reflex::ReflexHand;

/// Kinds of hands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HandKind {
    /// Nothing.
    None,
    /// The robot's electric gripper.
    Electric,
    /// A ReFlex hand, which has a driver of its own.
    Reflex,
}

/// A hand.
#[derive(Debug, Clone)]
pub enum Hand {
    /// Nothing.
    None,
    /// The robot's electric gripper.
    Electric(Gripper),
    /// A ReFlex hand.
    Reflex(ReflexHand),
}

impl Hand {
    /// The electric gripper, if that is what is mounted.
    pub fn electric(&self) -> Option<&Gripper> {
        match self {
            Self::Electric(gripper) => Some(gripper),
            _ => None,
        }
    }

    /// The electric gripper, for its commands.
    pub fn electric_mut(&mut self) -> Option<&mut Gripper> {
        match self {
            Self::Electric(gripper) => Some(gripper),
            _ => None,
        }
    }

    /// The ReFlex hand, if that is what is mounted.
    pub fn reflex(&self) -> Option<&ReflexHand> {
        match self {
            Self::Reflex(hand) => Some(hand),
            _ => None,
        }
    }

    /// The ReFlex hand, for its commands.
    pub fn reflex_mut(&mut self) -> Option<&mut ReflexHand> {
        match self {
            Self::Reflex(hand) => Some(hand),
            _ => None,
        }
    }

    /// Puts an object of this thickness (m) between the fingers and closes them on it, as if a person handed it over; `None`
    /// takes the object away. A second call with the same thickness changes nothing.
    pub fn hold(&mut self, object_width_m: Option<f64>) {
        match self {
            Self::None => {}
            Self::Electric(gripper) => gripper.hold(object_width_m),
            Self::Reflex(hand) => hand.hold(object_width_m),
        }
    }

    pub(crate) fn step(&mut self, dt_s: f64, robot_enabled: bool) {
        match self {
            Self::None => {}
            Self::Electric(gripper) => gripper.step(dt_s, robot_enabled),
            Self::Reflex(hand) => hand.step(dt_s),
        }
    }
}
