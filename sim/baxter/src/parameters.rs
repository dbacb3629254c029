//! Settings of the simulated robot.

use baxter::Side;
use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};

use crate::hand::HandKind;
use crate::scan_pose::ScanPose;

/// Settings, with the defaults of the real robot as far as they are known.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Is the robot enabled at start? A real one is not.
    pub enabled: bool,
    /// Does `/robot/state` say `ready` while enabled? Firmware 1.1 and the maker's emulator never do.
    pub reports_ready: bool,
    /// How long enabling takes.
    pub enabling_s: f64,
    /// Fraction of the velocity limits used in position mode.
    pub speed_ratio: f64,
    /// Silence after which an arm holds.
    pub command_timeout_s: f64,
    /// From a command's arrival to its effect.
    pub command_delay_s: f64,
    /// Acceleration of s0, s1, e0 and e1. Assumed; the maker gives none.
    pub acceleration_max_upper_arm_rad_s2: f64,
    /// Acceleration of w0, w1 and w2. Assumed; the maker gives none.
    pub acceleration_max_wrist_rad_s2: f64,
    /// Standard deviation of the angles reported; 0 switches it off.
    pub position_noise_rad: f64,
    /// Standard deviation of the velocities reported; 0 switches it off.
    pub velocity_noise_rad_s: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Which arm stands in the scan pose at start, left or right; the other one rests.
    pub side: Side,
    /// What is mounted on the left wrist: none, electric or reflex.
    pub left_hand: HandKind,
    /// What is mounted on the right wrist.
    pub right_hand: HandKind,
    /// Gap between the gripper's paddles when closed: narrow fingers in the fourth slot, as in the URDF.
    pub gripper_closed_gap_m: f64,
    /// Is the gripper calibrated at start? A real one is not.
    pub gripper_calibrated: bool,
    /// Where arm and head are at start.
    pub scan_pose: ScanPose,
    /// Messages per second on the fast topics: joints, state, end points, gripper.
    pub rate_hz: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            enabled: true,
            reports_ready: true,
            enabling_s: 0.3,
            speed_ratio: 0.3,
            command_timeout_s: 0.2,
            command_delay_s: 0.0045,
            acceleration_max_upper_arm_rad_s2: 10.0,
            acceleration_max_wrist_rad_s2: 40.0,
            position_noise_rad: 5e-5,
            velocity_noise_rad_s: 1e-3,
            seed: 1,
            side: Side::Left,
            left_hand: HandKind::Electric,
            right_hand: HandKind::Electric,
            gripper_closed_gap_m: 0.054,
            gripper_calibrated: false,
            scan_pose: ScanPose::default(),
            rate_hz: 100.0,
        }
    }
}

impl Parameters {
    /// Checks every range.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self;
            enabling_s: 0.0..=5.0;
            speed_ratio: 0.0..=1.0;
            command_timeout_s: 0.0..=1.0;
            command_delay_s: 0.0..=0.1;
            acceleration_max_upper_arm_rad_s2: 0.1..=1000.0;
            acceleration_max_wrist_rad_s2: 0.1..=1000.0;
            position_noise_rad: 0.0..=0.1;
            velocity_noise_rad_s: 0.0..=1.0;
            gripper_closed_gap_m: 0.0..=0.2;
            rate_hz: 1.0..=1000.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn defaults_are_valid_and_faults_are_named() {
        Parameters::default().validate().unwrap();
        let fault = Parameters {
            speed_ratio: f64::NAN,
            ..Default::default()
        };
        let text = fault.validate().unwrap_err().to_string();
        assert!(
            text.contains("speed_ratio") && text.contains("0 to 1"),
            "{text}"
        );
        assert!(serde_yaml::from_str::<Parameters>("speed_ration: 0.2").is_err());
    }
}
