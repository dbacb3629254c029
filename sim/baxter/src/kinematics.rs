//! Where the links are, from the joint angles and the URDF.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use crate::urdf::{Joint, Limits, Urdf, UrdfError};

/// Joints in an arm.
pub const JOINTS_PER_ARM: usize = 7;

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
    /// Both.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// As in topic, joint and frame names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// Names of an arm's joints in the robot's order: s0, s1, e0, e1, w0, w1, w2.
pub fn arm_joint_names(side: Side) -> [&'static str; JOINTS_PER_ARM] {
    match side {
        Side::Left => [
            "left_s0", "left_s1", "left_e0", "left_e1", "left_w0", "left_w1", "left_w2",
        ],
        Side::Right => [
            "right_s0", "right_s1", "right_e0", "right_e1", "right_w0", "right_w1", "right_w2",
        ],
    }
}

/// Angles with which one arm is the mirror image of the other; both in the robot's order, rad.
pub fn mirrored(arm_rad: [f64; JOINTS_PER_ARM]) -> [f64; JOINTS_PER_ARM] {
    let [s0, s1, e0, e1, w0, w1, w2] = arm_rad;
    [-s0, s1, -e0, e1, -w0, w1, -w2]
}

/// The robot's links and how they hang together.
#[derive(Debug, Clone)]
pub struct Kinematics {
    urdf: Urdf,
}

/// Joints from `base` to a link, nearest to `base` first.
#[derive(Debug, Clone)]
pub struct Chain {
    joints: Vec<Joint>,
}

impl Kinematics {
    /// Of the simulated robot's own description.
    ///
    /// # Errors
    /// None, unless the file in the source tree has been damaged.
    pub fn baxter() -> Result<Self, UrdfError> {
        Ok(Self {
            urdf: Urdf::parse(Urdf::BAXTER)?,
        })
    }

    /// Of any description with Baxter's joint and link names.
    pub fn new(urdf: Urdf) -> Self {
        Self { urdf }
    }

    /// The joints from the root to `link`.
    ///
    /// # Errors
    /// No such link, or a loop above it.
    pub fn chain(&self, link: &str) -> Result<Chain, UrdfError> {
        let mut joints = Vec::new();
        let mut child = link;
        while let Some(joint) = self.urdf.joints.iter().find(|joint| joint.child == child) {
            joints.push(joint.clone());
            child = &joint.parent;
            if joints.len() > self.urdf.joints.len() {
                break;
            }
        }
        if joints.is_empty() || joints.len() > self.urdf.joints.len() {
            return Err(UrdfError::Unknown {
                kind: "link",
                name: link.to_owned(),
            });
        }
        joints.reverse();
        Ok(Chain { joints })
    }

    /// Limits of an arm's joints in the robot's order: rad, rad/s.
    ///
    /// # Errors
    /// The description lacks one of the joints, or has it fixed.
    pub fn arm_limits(&self, side: Side) -> Result<[Limits; JOINTS_PER_ARM], UrdfError> {
        let mut limits = [Limits {
            lower: 0.0,
            upper: 0.0,
            velocity: 0.0,
        }; JOINTS_PER_ARM];
        for (limits, name) in limits.iter_mut().zip(arm_joint_names(side)) {
            *limits = self.limits(name)?;
        }
        Ok(limits)
    }

    /// Limits of one joint.
    ///
    /// # Errors
    /// No such joint, or it is fixed.
    pub fn limits(&self, joint: &str) -> Result<Limits, UrdfError> {
        let limits = self.urdf.joint(joint)?.limits;
        limits.ok_or_else(|| UrdfError::Lacks {
            joint: joint.to_owned(),
            what: "limit",
        })
    }

    /// Hand frame (`left_hand` or `right_hand`) in `base` for arm angles in the robot's order, rad.
    ///
    /// # Errors
    /// The description has no such hand.
    pub fn base_from_hand(
        &self,
        side: Side,
        angles_rad: &[f64; JOINTS_PER_ARM],
    ) -> Result<Isometry3<f64>, UrdfError> {
        let chain = self.chain(&format!("{}_hand", side.name()))?;
        Ok(chain.base_from_link(arm_positions(side, angles_rad)))
    }
}

impl Chain {
    /// The chain's last link in `base`; `position` gives a joint's position by its name (rad, metres).
    pub fn base_from_link(&self, position: impl Fn(&str) -> f64) -> Isometry3<f64> {
        let position = |joint: &Joint| match &joint.mimics {
            Some((copied, factor)) => factor * position(copied),
            None => position(&joint.name),
        };
        self.joints
            .iter()
            .fold(Isometry3::identity(), |base_from_parent, joint| {
                base_from_parent * joint.parent_from_child(position(joint))
            })
    }
}

/// Positions by name for [`Chain::base_from_link`] from an arm's angles; 0 for all other joints.
pub(crate) fn arm_positions(
    side: Side,
    angles_rad: &[f64; JOINTS_PER_ARM],
) -> impl Fn(&str) -> f64 {
    let (names, angles_rad) = (arm_joint_names(side), *angles_rad);
    move |joint| {
        let index = names.iter().position(|name| *name == joint);
        index.map_or(0.0, |index| angles_rad[index])
    }
}
