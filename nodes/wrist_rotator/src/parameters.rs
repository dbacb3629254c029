//! Settings of the wrist rotator.

use baxter::{REST_DWELL_S, REST_VELOCITY_RAD_S, Side, W2};
use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};

use crate::setpoints::RateLimits;

/// Longest time that the commanded angle may take to come to rest, s. The rest of the 0.25 s within which the arm has to rest
/// is for the message that says why, the tick, the command's way to the robot, and the arm, which follows a little later.
const RAMP_MAX_S: f64 = 0.2;

/// What is heard of the arm's surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surroundings {
    /// Whether a person holds the cuff.
    Cuff,
    /// What collision avoidance sees too near.
    CollisionAvoidance,
    /// Whether collision detection feels an impact.
    CollisionDetection,
}

/// Settings, with defaults for W2 of a Baxter that holds a light object.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Arm whose W2 is turned.
    pub side: Side,
    /// Commands sent per second. The robot lets go at 5.
    pub rate_hz: f64,
    /// Speed ratio that the robot is told before each motion; it would otherwise keep that of its last client.
    pub speed_ratio: f64,
    /// Largest speed of the commanded angle; less than the speed ratio times the joint's limit, so that the arm keeps up.
    pub velocity_max_rad_s: f64,
    /// Largest acceleration of the commanded angle.
    pub acceleration_max_rad_s2: f64,
    /// Largest jerk of the commanded angle.
    pub jerk_max_rad_s3: f64,
    /// Largest acceleration where a motion is ended before its target, or held.
    pub stop_acceleration_max_rad_s2: f64,
    /// Largest jerk there; with the acceleration it must stop the wrist within 0.2 s.
    pub stop_jerk_max_rad_s3: f64,
    /// Lower end of the joint's range, as in the robot's URDF.
    pub angle_min_rad: f64,
    /// Upper end of the joint's range.
    pub angle_max_rad: f64,
    /// The joint's velocity limit, as in the robot's URDF.
    pub joint_velocity_max_rad_s: f64,
    /// Distance from the target that counts as there.
    pub tolerance_rad: f64,
    /// Speed that counts as rest.
    pub rest_velocity_rad_s: f64,
    /// Time for which the joint must be there and at rest.
    pub dwell_s: f64,
    /// Time allowed beyond the trajectory's own before the motion is given up.
    pub deadline_margin_s: f64,
    /// Distance between commanded and measured angle at which the trajectory waits for the arm.
    pub following_error_max_rad: f64,
    /// How long it waits before the motion is given up.
    pub following_patience_s: f64,
    /// Age at which `/robot/state` is too old to move on.
    pub state_age_max_s: f64,
    /// Age at which joint angles are too old to move on.
    pub joints_age_max_s: f64,
    /// Age at which the state of the cuff, of collision avoidance or of collision detection is too old to move on.
    pub surroundings_age_max_s: f64,
    /// Which of cuff, collision_avoidance and collision_detection need not be heard. For a simulator that lacks them; on a
    /// robot the arm would move blindly.
    pub waived: Vec<Surroundings>,
    /// Refuse while `/robot/state` does not say ready? Firmware 1.1 and the maker's emulator never say so.
    pub require_ready: bool,
    /// Move although `/robot/state` reports an error? It may be one that does not concern the arm.
    pub tolerate_error: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        let side = Side::Left;
        let limits = side.joint_limits()[W2];
        Self {
            side,
            rate_hz: 100.0,
            speed_ratio: 0.3,
            velocity_max_rad_s: 1.15,
            acceleration_max_rad_s2: 5.0,
            // Builds the acceleration up in 0.06 s.
            jerk_max_rad_s3: 80.0,
            // 0.175 s from the largest velocity and acceleration to rest.
            stop_acceleration_max_rad_s2: 10.0,
            stop_jerk_max_rad_s3: 250.0,
            angle_min_rad: limits.lower_rad,
            angle_max_rad: limits.upper_rad,
            joint_velocity_max_rad_s: limits.velocity_max_rad_s,
            tolerance_rad: 0.008_726_646,
            rest_velocity_rad_s: REST_VELOCITY_RAD_S,
            dwell_s: REST_DWELL_S,
            deadline_margin_s: 2.0,
            following_error_max_rad: 0.2,
            following_patience_s: 1.0,
            state_age_max_s: 0.5,
            joints_age_max_s: 0.2,
            surroundings_age_max_s: 0.5,
            waived: Vec::new(),
            require_ready: false,
            tolerate_error: false,
        }
    }
}

impl Parameters {
    /// Checks every range.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let reachable_rad_s = self.speed_ratio * self.joint_velocity_max_rad_s;
        check_ranges! { self;
            rate_hz: 10.0..=1000.0;
            speed_ratio: 0.01..=1.0;
            joint_velocity_max_rad_s: 0.1..=10.0;
            velocity_max_rad_s: 0.01..=reachable_rad_s;
            acceleration_max_rad_s2: 0.01..=100.0;
            jerk_max_rad_s3: 0.1..=10_000.0;
            stop_acceleration_max_rad_s2: self.acceleration_max_rad_s2..=100.0;
            stop_jerk_max_rad_s3: self.jerk_max_rad_s3..=10_000.0;
            surroundings_age_max_s: 0.02..=5.0;
            angle_min_rad: -3.2..=3.2;
            angle_max_rad: self.angle_min_rad..=3.2;
            tolerance_rad: 1e-4..=0.2;
            rest_velocity_rad_s: 1e-3..=1.0;
            dwell_s: 0.0..=5.0;
            deadline_margin_s: 0.1..=60.0;
            following_error_max_rad: 0.02..=1.0;
            following_patience_s: 0.0..=10.0;
            state_age_max_s: 0.02..=5.0;
            joints_age_max_s: 0.02..=5.0;
        }
        let ramp_s = self.longest_ramp_s();
        if ramp_s > RAMP_MAX_S {
            let allowed = format!(
                "so large that a stop from velocity_max_rad_s takes at most {RAMP_MAX_S} s, not {ramp_s:.2}; raise \
                 stop_jerk_max_rad_s3 with it, or lower velocity_max_rad_s"
            );
            let (name, value) = (
                "stop_acceleration_max_rad_s2",
                self.stop_acceleration_max_rad_s2,
            );
            return Err(ParameterError::new(name, value, allowed));
        }
        Ok(())
    }

    /// Limits of setpoints on the way to a target.
    pub fn limits(&self) -> RateLimits {
        RateLimits {
            velocity_rad_s: self.velocity_max_rad_s,
            acceleration_rad_s2: self.acceleration_max_rad_s2,
            jerk_rad_s3: self.jerk_max_rad_s3,
        }
    }

    /// Limits of setpoints that come to rest before it.
    pub fn stop_limits(&self) -> RateLimits {
        RateLimits {
            velocity_rad_s: self.velocity_max_rad_s,
            acceleration_rad_s2: self.stop_acceleration_max_rad_s2,
            jerk_rad_s3: self.stop_jerk_max_rad_s3,
        }
    }

    /// Upper bound of the time from any setpoint to rest, s: the acceleration goes to 0, then slows down from the largest
    /// velocity along a ramp with rounded ends.
    fn longest_ramp_s(&self) -> f64 {
        let (acceleration, jerk) = (self.stop_acceleration_max_rad_s2, self.stop_jerk_max_rad_s3);
        (self.acceleration_max_rad_s2 + acceleration) / jerk
            + self.velocity_max_rad_s / acceleration
    }
}

impl Surroundings {
    /// As the parameter `waived` has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cuff => "cuff",
            Self::CollisionAvoidance => "collision_avoidance",
            Self::CollisionDetection => "collision_detection",
        }
    }

    /// Where it is heard for one arm.
    pub fn topic(self, side: Side) -> String {
        match self {
            Self::Cuff => side.cuff_topic(),
            Self::CollisionAvoidance => format!("{}/collision_avoidance_state", side.limb_topics()),
            Self::CollisionDetection => format!("{}/collision_detection_state", side.limb_topics()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn defaults_are_valid_and_faults_are_named() {
        Parameters::default().validate().unwrap();
        let too_fast = Parameters {
            velocity_max_rad_s: 1.3,
            ..Default::default()
        };
        let text = too_fast.validate().unwrap_err().to_string();
        assert!(
            text.contains("velocity_max_rad_s is 1.3") && text.contains("1.2"),
            "{text}"
        );
        let gentle = Parameters {
            stop_jerk_max_rad_s3: 100.0,
            ..Default::default()
        };
        let text = gentle.validate().unwrap_err().to_string();
        assert!(text.contains("at most 0.2 s, not 0.27"), "{text}");
        let no_number = Parameters {
            dwell_s: f64::NAN,
            ..Default::default()
        };
        assert_eq!(no_number.validate().unwrap_err().name, "dwell_s");
    }

    #[test]
    fn sides_are_lower_case_and_unknown_keys_are_refused() {
        let right: Parameters = serde_yaml::from_str("side: right").unwrap();
        assert_eq!(right.side.joint_names()[W2], "right_w2");
        assert!(serde_yaml::from_str::<Parameters>("sides: right").is_err());
        let waived: Parameters = serde_yaml::from_str("waived: [cuff]").unwrap();
        assert_eq!(waived.waived, [Surroundings::Cuff]);
        assert!(serde_yaml::from_str::<Parameters>("waived: [cuffs]").is_err());
    }
}
