//! Settings of the gripper node.

use baxter::{Gap, Side, StateRules};
use parameter::{ParameterError, check_ranges};
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// What is mounted on the wrist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HandKind {
    /// Baxter's electric gripper.
    Electric,
    /// A ReFlex hand.
    Reflex,
}

/// Settings of the node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// What is mounted: electric or reflex.
    pub hand: HandKind,
    /// On which arm: left or right.
    pub side: Side,
    /// Age at which a message of the robot or the gripper is too old to act on, s.
    pub state_age_max_s: f64,
    /// Time for the fingers to come to rest, s.
    pub motion_patience_s: f64,
    /// Time at rest that ends a motion, s.
    pub settle_s: f64,
    /// Settings of an electric gripper.
    pub electric: ElectricParameters,
    /// Settings of a ReFlex hand.
    pub reflex: ReflexParameters,
}

/// Settings of an electric gripper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ElectricParameters {
    /// Distance between the fingers; depends on which fingers are in which slots.
    pub gap: Gap,
    /// Whether to calibrate a gripper that does not know the ends of its travel. Calibration opens the hand.
    pub calibrate: bool,
    /// Speed of the fingers, share of the largest.
    pub velocity: f64,
    /// Force at which moving fingers stop, share of the largest.
    pub moving_force: f64,
    /// Force with which they then hold, share of the largest.
    pub holding_force: f64,
    /// Distance from its target at which the gripper counts as arrived, share of the travel.
    pub dead_zone: f64,
    /// Time for the gripper to acknowledge a command, s.
    pub acknowledge_patience_s: f64,
    /// Time for a calibration, s.
    pub calibration_patience_s: f64,
}

/// Settings of a ReFlex hand. Angles are its driver's: 0 is open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReflexParameters {
    /// Namespace of the hand's driver; empty: /hand2/reflex_takktile on the left, /reflex_takktile on the right.
    pub base: String,
    /// Distance between the fingertips when open, m. The default is an assumption: measure it. The distance is taken to be
    /// linear in the angle.
    pub open_width_m: f64,
    /// Angle of closed fingers, rad.
    pub closed_rad: f64,
    /// Turn of fingers f1 and f2 about their bases, rad.
    pub preshape_rad: f64,
    /// Speed of the fingers, rad/s.
    pub speed_rad_s: f64,
    /// Load of a motor that counts as the hand's largest force; from 350 on the driver loosens by itself.
    pub load_max: f64,
    /// Force at which fingers stop, share of `load_max`.
    pub force: f64,
    /// Largest lead of the commanded angle over the measured one, rad.
    pub lead_max_rad: f64,
    /// Distance from its target at which a finger counts as arrived, rad.
    pub tolerance_rad: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            hand: HandKind::Electric,
            side: Side::Left,
            state_age_max_s: 0.5,
            motion_patience_s: 5.0,
            settle_s: 0.2,
            electric: ElectricParameters::default(),
            reflex: ReflexParameters::default(),
        }
    }
}

impl Default for ElectricParameters {
    /// Velocity, forces and dead zone are those of the maker's client.
    fn default() -> Self {
        Self {
            gap: Gap::default(),
            calibrate: true,
            velocity: 0.5,
            moving_force: 0.4,
            holding_force: 0.3,
            dead_zone: 0.05,
            acknowledge_patience_s: 1.0,
            calibration_patience_s: 5.0,
        }
    }
}

impl Default for ReflexParameters {
    fn default() -> Self {
        Self {
            base: String::new(),
            open_width_m: 0.14,
            closed_rad: 2.1817,
            preshape_rad: 0.0,
            speed_rad_s: 1.5,
            load_max: 350.0,
            force: 0.5,
            lead_max_rad: 0.4,
            tolerance_rad: 0.1,
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
            state_age_max_s: 0.05..=5.0, "s";
            motion_patience_s: 0.5..=60.0, "s";
            settle_s: 0.02..=2.0, "s";
        }
        self.electric.validate()?;
        self.reflex.validate()
    }

    /// Which states of the robot forbid a grasp.
    pub fn state_rules(&self) -> StateRules {
        StateRules {
            age_max: Duration::from_secs_f64(self.state_age_max_s),
            require_ready: false,
            // The error may concern an arm; the gripper can still be used.
            tolerate_error: true,
        }
    }

    /// Prefix of the electric gripper's topics.
    pub fn electric_base(&self) -> String {
        self.side.gripper_topics()
    }

    /// Prefix of the ReFlex hand's topics.
    pub fn reflex_base(&self) -> String {
        self.reflex.topics_on(self.side)
    }
}

impl ReflexParameters {
    /// Prefix of the topics of a hand on this arm.
    pub fn topics_on(&self, side: Side) -> String {
        match &self.base[..] {
            "" => side.reflex_topics().into(),
            base => base.trim_end_matches('/').into(),
        }
    }

    /// Distance between the fingertips at this mean angle of the fingers, m.
    pub fn width_m(&self, angle_rad: f64) -> f64 {
        (self.open_width_m * (1.0 - angle_rad / self.closed_rad)).max(0.0)
    }
}

impl ElectricParameters {
    fn validate(&self) -> Result<(), ParameterError> {
        self.gap.validate()?;
        check_ranges! { self, "electric/";
            velocity: 0.01..=1.0;
            moving_force: 0.01..=1.0;
            holding_force: 0.01..=1.0;
            dead_zone: 0.01..=1.0;
            acknowledge_patience_s: 0.1..=60.0, "s";
            calibration_patience_s: 0.1..=60.0, "s";
        }
        Ok(())
    }
}

impl ReflexParameters {
    /// Largest angle that the driver takes, rad.
    const ANGLE_MAX_RAD: f64 = 3.6;
    /// Largest preshape that the driver takes, rad.
    const PRESHAPE_MAX_RAD: f64 = 1.75;

    fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self, "reflex/";
            open_width_m: 0.01..=0.5, "m";
            closed_rad: 0.1..=Self::ANGLE_MAX_RAD, "rad";
            preshape_rad: 0.0..=Self::PRESHAPE_MAX_RAD, "rad";
            speed_rad_s: 0.1..=3.5, "rad/s";
            load_max: 1.0..=1000.0;
            force: 0.01..=1.0;
            lead_max_rad: 0.01..=1.0, "rad";
            tolerance_rad: 0.01..=0.5, "rad";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn parameters(yaml: &str) -> Result<Parameters, serde_yaml::Error> {
        serde_yaml::from_str(yaml)
    }

    #[test]
    fn defaults_are_valid_and_faults_are_named() {
        Parameters::default().validate().unwrap();
        for (yaml, words) in [
            ("settle_s: .nan", "settle_s"),
            ("electric: {velocity: 50}", "electric/velocity is 50"),
            ("electric: {gap: {closed_m: 0.2}}", "gap/closed_m is 0.2"),
            ("reflex: {closed_rad: 4.0}", "reflex/closed_rad is 4"),
        ] {
            let error = parameters(yaml).unwrap().validate().unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
        assert!(parameters("reflex: {clozed_rad: 2.0}").is_err());
    }

    #[test]
    fn hands_are_where_the_drivers_put_them() {
        let base = |yaml| parameters(yaml).unwrap().reflex_base();
        assert_eq!(base("side: left"), "/hand2/reflex_takktile");
        assert_eq!(base("side: right"), "/reflex_takktile");
        assert_eq!(base("{side: right, reflex: {base: /my_hand/}}"), "/my_hand");
    }
}
