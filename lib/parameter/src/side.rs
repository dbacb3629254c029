//! Which of the robot's arms a node is for.

use serde::{Deserialize, Serialize};

/// Joints in an arm.
pub const JOINTS_PER_ARM: usize = 7;

/// Which arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The robot's own left.
    Left,
    /// The robot's own right.
    Right,
}

impl Side {
    /// As in topic and joint names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// TF frame of the hand; +z is out along the gripper.
    pub fn hand_frame(self) -> &'static str {
        match self {
            Self::Left => "left_hand",
            Self::Right => "right_hand",
        }
    }

    /// The joint that turns the hand about its own axis.
    pub fn wrist_joint(self) -> &'static str {
        self.joint_names()[JOINTS_PER_ARM - 1]
    }

    /// Joint names in the robot's order: s0, s1, e0, e1, w0, w1, w2.
    pub fn joint_names(self) -> [&'static str; JOINTS_PER_ARM] {
        match self {
            Self::Left => [
                "left_s0", "left_s1", "left_e0", "left_e1", "left_w0", "left_w1", "left_w2",
            ],
            Self::Right => [
                "right_s0", "right_s1", "right_e0", "right_e1", "right_w0", "right_w1", "right_w2",
            ],
        }
    }
}
