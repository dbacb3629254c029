//! The robot's two arms: the names of their joints, frames and topics, and the limits of their joints.

use serde::{Deserialize, Serialize};

use crate::joint::JointLimits;

/// Joints in an arm.
pub const JOINTS_PER_ARM: usize = 7;

/// Index of W2, which turns the hand about its own axis, among an arm's joints.
pub const W2: usize = 6;

/// Which arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The robot's own left.
    Left,
    /// The robot's own right.
    Right,
}

impl Side {
    /// Both arms.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// `left` or `right`, as in topic and joint names.
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
        self.joint_names()[W2]
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

    /// Limits of the joints in the robot's order, as in the maker's URDF; the same for both arms. A robot's own
    /// description, on `/robot_description`, carries calibrated offsets but the same limits.
    // The URDF's digits: half a turn in full precision would lie beyond its limit.
    #[expect(clippy::approx_constant)]
    pub const fn joint_limits(self) -> [JointLimits; JOINTS_PER_ARM] {
        [
            JointLimits::new(-1.701_679_938_78, 1.701_679_938_78, 1.5),
            JointLimits::new(-2.147, 1.047, 1.5),
            JointLimits::new(-3.054_179_938_78, 3.054_179_938_78, 1.5),
            JointLimits::new(-0.05, 2.618, 1.5),
            JointLimits::new(-3.059, 3.059, 4.0),
            JointLimits::new(-1.570_796_326_79, 2.094, 4.0),
            JointLimits::new(-3.059, 3.059, 4.0),
        ]
    }

    /// Prefix of this arm's topics.
    pub fn limb_topics(self) -> String {
        format!("/robot/limb/{}", self.name())
    }

    /// Topic of the cuff's digital input: whether somebody holds this arm's cuff.
    pub fn cuff_topic(self) -> String {
        format!("/robot/digital_io/{}_lower_cuff/state", self.name())
    }

    /// Prefix of the topics of this arm's electric gripper.
    pub fn gripper_topics(self) -> String {
        format!("/robot/end_effector/{}_gripper", self.name())
    }

    /// Prefix of the topics of this arm's ReFlex hand, unless its driver was started in another namespace. The left hand is
    /// the driver's second one.
    pub fn reflex_topics(self) -> &'static str {
        match self {
            Self::Left => "/hand2/reflex_takktile",
            Self::Right => "/reflex_takktile",
        }
    }
}

/// Joint angles with which the other arm is the mirror image of this one; both in the robot's order, rad.
pub fn mirrored(arm_rad: [f64; JOINTS_PER_ARM]) -> [f64; JOINTS_PER_ARM] {
    let [s0, s1, e0, e1, w0, w1, w2] = arm_rad;
    [-s0, s1, -e0, e1, -w0, w1, -w2]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sides_are_written_in_lower_case() {
        for side in Side::BOTH {
            assert_eq!(serde_yaml::from_str::<Side>(side.name()).unwrap(), side);
            assert!(
                side.joint_names()
                    .iter()
                    .all(|name| name.starts_with(side.name()))
            );
        }
        assert!(serde_yaml::from_str::<Side>("Left").is_err());
        assert_eq!(Side::Right.wrist_joint(), "right_w2");
    }
}
