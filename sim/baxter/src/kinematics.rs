//! Where the links are, from the joint angles and the URDF.

use baxter::{JOINTS_PER_ARM, Side};
use nalgebra::Isometry3;

use crate::urdf::{Joint, Limits, Urdf, UrdfError};

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
        for (limits, name) in limits.iter_mut().zip(side.joint_names()) {
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
        let chain = self.chain(side.hand_frame())?;
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
    let (names, angles_rad) = (side.joint_names(), *angles_rad);
    move |joint| {
        let index = names.iter().position(|name| *name == joint);
        index.map_or(0.0, |index| angles_rad[index])
    }
}
