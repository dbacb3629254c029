//! One joint: its limits and its last measured state.

use std::time::Duration;

/// Range and speed of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// Smallest angle, rad.
    pub lower_rad: f64,
    /// Largest angle, rad.
    pub upper_rad: f64,
    /// Largest speed, rad/s.
    pub velocity_max_rad_s: f64,
}

impl JointLimits {
    pub(crate) const fn new(lower_rad: f64, upper_rad: f64, velocity_max_rad_s: f64) -> Self {
        Self {
            lower_rad,
            upper_rad,
            velocity_max_rad_s,
        }
    }
}

/// One joint as `/robot/joint_states` last gave it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// Angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s, where the message had one.
    pub velocity_rad_s: Option<f64>,
    /// The message's stamp, since the epoch of ROS time.
    pub stamp: Duration,
}

impl JointSample {
    /// Finds `joint` in a joint_states message by its name, since the robot publishes messages of several layouts on the
    /// topic. `None` if the message does not have the joint, which is normal, or if its list of positions is too short.
    pub fn find(
        joint: &str,
        names: &[String],
        positions_rad: &[f64],
        velocities_rad_s: &[f64],
        stamp: Duration,
    ) -> Option<Self> {
        let index = names.iter().position(|name| name == joint)?;
        Some(Self {
            angle_rad: *positions_rad.get(index)?,
            velocity_rad_s: velocities_rad_s.get(index).copied(),
            stamp,
        })
    }
}
