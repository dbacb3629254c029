//! The pose in which objects are scanned, as in `config/scan_pose.yaml`.

use baxter::{JOINTS_PER_ARM, Side};
use serde::{Deserialize, Serialize};

use crate::kinematics::Kinematics;
use crate::urdf::UrdfError;

/// Angles of the left arm and the head, rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScanPose {
    /// Angles of the left arm by joint.
    pub left_arm_rad: LeftArm,
    /// Angle of the head; positive turns it to the robot's left.
    pub head_pan_rad: f64,
}

/// Angles of the left arm's joints, rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // The names say it: one field for each joint.
pub struct LeftArm {
    pub left_s0: f64,
    pub left_s1: f64,
    pub left_e0: f64,
    pub left_e1: f64,
    pub left_w0: f64,
    pub left_w1: f64,
    pub left_w2: f64,
}

/// What is wrong with a scan pose.
#[derive(Debug, thiserror::Error)]
pub enum ScanPoseError {
    /// Not the expected YAML.
    #[error("scan pose: {0}; give left_arm_rad with all seven joints, and head_pan_rad")]
    Yaml(#[from] serde_yaml::Error),
    /// A joint cannot go there.
    #[error("scan pose: {joint} is {angle_rad} rad; allowed are {lower_rad} to {upper_rad}")]
    OutsideLimits {
        /// Joint.
        joint: String,
        /// Asked angle.
        angle_rad: f64,
        /// Lower limit.
        lower_rad: f64,
        /// Upper limit.
        upper_rad: f64,
    },
    /// The robot has no such joint.
    #[error(transparent)]
    Urdf(#[from] UrdfError),
}

impl Default for ScanPose {
    /// The gripper straight up, 0.40 m in front of the head camera.
    fn default() -> Self {
        let left_arm_rad = LeftArm {
            left_s0: -0.387,
            left_s1: 0.355,
            left_e0: -1.435,
            left_e1: 1.603,
            left_w0: -1.209,
            left_w1: 1.686,
            left_w2: 1.25,
        };
        Self {
            left_arm_rad,
            head_pan_rad: 0.0,
        }
    }
}

impl ScanPose {
    /// Reads a pose from YAML and checks it against the joint limits.
    ///
    /// # Errors
    /// Malformed YAML, an unknown or a missing key, an angle outside its joint's limits.
    pub fn from_yaml(text: &str, kinematics: &Kinematics) -> Result<Self, ScanPoseError> {
        let pose: Self = serde_yaml::from_str(text)?;
        pose.validate(kinematics)?;
        Ok(pose)
    }

    /// Checks the angles against the joint limits.
    ///
    /// # Errors
    /// An angle outside its joint's limits.
    pub fn validate(&self, kinematics: &Kinematics) -> Result<(), ScanPoseError> {
        let names = Side::Left.joint_names();
        for (name, angle_rad) in names.into_iter().zip(self.left_arm()) {
            check(kinematics, name, angle_rad)?;
        }
        check(kinematics, "head_pan", self.head_pan_rad)
    }

    /// The left arm's angles in the robot's order, rad.
    pub fn left_arm(&self) -> [f64; JOINTS_PER_ARM] {
        let arm = &self.left_arm_rad;
        [
            arm.left_s0,
            arm.left_s1,
            arm.left_e0,
            arm.left_e1,
            arm.left_w0,
            arm.left_w1,
            arm.left_w2,
        ]
    }
}

fn check(kinematics: &Kinematics, joint: &str, angle_rad: f64) -> Result<(), ScanPoseError> {
    let limits = kinematics.limits(joint)?;
    // Written so that NaN fails.
    if angle_rad >= limits.lower && angle_rad <= limits.upper {
        return Ok(());
    }
    Err(ScanPoseError::OutsideLimits {
        joint: joint.to_owned(),
        angle_rad,
        lower_rad: limits.lower,
        upper_rad: limits.upper,
    })
}
