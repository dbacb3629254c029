//! Whether whoever commands an arm keeps the contract of motion, as far as the robot can see: setpoints within limits from the
//! first to the last, and none while something forbids motion. That somebody waits for the motion a robot cannot see.

mod pauses;

use std::collections::BTreeSet;

use baxter::{JOINTS_PER_ARM, JointLimits, Side};
use pauses::{HOLD_S, pauses_s, period_s, readings};

/// Largest rates of change of setpoints: rad/s, rad/s², rad/s³. Those within which `wrist_rotator` stops; on its way to a target
/// it stays well below. The velocity is W2's 4 rad/s times the usual speed ratio of 0.3.
const RATES_MAX: [f64; 3] = [1.2, 10.0, 250.0];
/// What rounding and a wrong estimate of the commander's period add to velocity, acceleration and jerk, as factors.
const RATE_SLACK: [f64; 3] = [1.1, 1.25, 1.5];
/// Pause after which the robot has let go of the last setpoint, s: the timeout of position mode.
const LET_GO_S: f64 = 0.2;
/// Distance of a first setpoint from the arm, rad.
const START_ERROR_MAX_RAD: f64 = 0.05;
/// Distance from the arm within which a setpoint leaves it where it is, rad.
const AT_ARM_RAD: f64 = 0.003;
/// How long setpoints may come after something has come to forbid them, s: a period of the slowest topic that says so
/// (0.1), the time in which the arm has to rest (0.25), and what a busy computer adds.
const REACTION_S: f64 = 0.5;

/// Angles of some of an arm's joints, rad, in the robot's order.
pub(crate) type Setpoint = [Option<f64>; JOINTS_PER_ARM];

/// Watches one arm.
#[derive(Debug, Clone)]
pub(crate) struct Contract {
    side: Side,
    limits: [JointLimits; JOINTS_PER_ARM],
    /// Setpoints and the times of their arrival, s, since the arm last rested without.
    sequence: Vec<(f64, Setpoint)>,
    /// Where in it a commander may have begun anew: with the arm where it is, after a rest.
    beginnings: Vec<usize>,
    /// What forbids motion, and since when, s.
    forbidden: Option<(&'static str, f64)>,
    /// Whether the robot itself ended the sequence, by not taking commands.
    cut: bool,
    violations: BTreeSet<String>,
}

impl Contract {
    pub fn new(side: Side) -> Self {
        Self {
            side,
            limits: side.joint_limits(),
            sequence: Vec::new(),
            beginnings: Vec::new(),
            forbidden: None,
            cut: false,
            violations: BTreeSet::new(),
        }
    }

    /// Notes what forbids motion now, and whether the robot takes no commands meanwhile.
    pub fn forbid(&mut self, reason: Option<&'static str>, takes_commands: bool, time_s: f64) {
        self.cut |= !takes_commands && !self.sequence.is_empty();
        self.forbidden = match (reason, self.forbidden) {
            (None, _) => None,
            (Some(_), Some(since)) => Some(since),
            (Some(reason), None) => Some((reason, time_s)),
        };
        self.close_when_silent(time_s);
    }

    /// Notes a setpoint that arrives while the arm's true angles are `angles_rad`.
    pub fn receive(&mut self, setpoint: Setpoint, angles_rad: &[f64; JOINTS_PER_ARM], time_s: f64) {
        self.close_when_silent(time_s);
        if self.begins_at_the_arm(&setpoint, angles_rad, time_s) {
            self.beginnings.push(self.sequence.len());
        }
        if let Some((reason, since_s)) = self.forbidden
            && time_s - since_s > REACTION_S
        {
            self.violate(format!("commanded although {reason}"));
        }
        for (joint, (setpoint_rad, limits)) in setpoint.into_iter().zip(self.limits).enumerate() {
            let Some(setpoint_rad) = setpoint_rad else {
                continue;
            };
            let range_rad = limits.lower_rad - 1e-3..=limits.upper_rad + 1e-3;
            if !range_rad.contains(&setpoint_rad) {
                self.violate(format!(
                    "{} commanded to {setpoint_rad:.3} rad",
                    self.name(joint)
                ));
            }
            let error_rad = (setpoint_rad - angles_rad[joint]).abs();
            if self.sequence.is_empty() && error_rad > START_ERROR_MAX_RAD {
                self.violate(format!(
                    "{} begins {error_rad:.3} rad from the arm",
                    self.name(joint)
                ));
            }
        }
        self.sequence.push((time_s, setpoint));
    }

    /// What was done against the contract until now, and not told before. Takes the last setpoint for the end.
    pub fn take_violations(&mut self) -> Vec<String> {
        std::mem::take(&mut self.violations).into_iter().collect()
    }

    fn name(&self, joint: usize) -> &'static str {
        self.side.joint_names()[joint]
    }

    fn violate(&mut self, text: String) {
        self.violations
            .insert(format!("{} arm: {text}", self.side.name()));
    }

    /// Whether a setpoint that comes after a rest leaves the arm where it is. That is elsewhere than the last setpoint where the
    /// arm was blocked, or the robot took no commands.
    fn begins_at_the_arm(
        &self,
        setpoint: &Setpoint,
        angles_rad: &[f64; JOINTS_PER_ARM],
        time_s: f64,
    ) -> bool {
        let last_s = self.sequence.last().map(|(last_s, _)| *last_s);
        let is_at_arm = |(setpoint_rad, angle_rad): (&Option<f64>, &f64)| {
            setpoint_rad.is_none_or(|setpoint_rad| (setpoint_rad - angle_rad).abs() < AT_ARM_RAD)
        };
        last_s.is_some_and(|last_s| time_s - last_s > HOLD_S)
            && setpoint.iter().zip(angles_rad).all(is_at_arm)
    }

    fn close_when_silent(&mut self, time_s: f64) {
        let last_s = self.sequence.last().map(|(last_s, _)| *last_s);
        if last_s.is_some_and(|last_s| time_s - last_s > LET_GO_S) {
            self.close();
        }
    }

    /// Judges the setpoints since the arm last rested without.
    fn close(&mut self) {
        let sequence = std::mem::take(&mut self.sequence);
        let beginnings = std::mem::take(&mut self.beginnings);
        let cut = std::mem::take(&mut self.cut);
        for joint in 0..JOINTS_PER_ARM {
            let Some(excess) = against_contract(&sequence, joint, !cut) else {
                continue;
            };
            let ends = beginnings.iter().copied().chain([sequence.len()]);
            let mut parts = std::iter::once(0)
                .chain(beginnings.iter().copied())
                .zip(ends);
            let is_against = |(from, to): (usize, usize)| {
                against_contract(&sequence[from..to], joint, !cut).is_some()
            };
            if beginnings.is_empty() || parts.any(is_against) {
                self.violate(format!("{} {excess}", self.name(joint)));
            }
        }
    }
}

/// What is against the contract in a joint's setpoints, whichever way the commander's pauses are read: doubts count for it.
fn against_contract(sequence: &[(f64, Setpoint)], joint: usize, must_rest: bool) -> Option<String> {
    let angles_rad = sequence.iter().map(|(_, setpoint)| setpoint[joint]);
    let angles_rad: Vec<f64> = angles_rad.collect::<Option<_>>()?;
    let times_s: Vec<f64> = sequence.iter().map(|(time_s, _)| *time_s).collect();
    let period_s = period_s(&times_s);
    let pauses_s = pauses_s(&times_s, period_s);
    let readings = readings(&angles_rad, &pauses_s, period_s);
    let excesses: Option<Vec<String>> = readings
        .map(|held_rad| excess(held_rad, must_rest, period_s))
        .collect();
    excesses?.into_iter().next()
}

/// The first rate of change beyond its limit, in words. A sequence that `must_rest` has to come to rest at its end.
fn excess(mut angles_rad: Vec<f64>, must_rest: bool, period_s: f64) -> Option<String> {
    let end = angles_rad.len();
    if let (true, Some(last_rad)) = (must_rest, angles_rad.last().copied()) {
        angles_rad.extend([last_rad; 3]);
    }
    let names = ["velocity", "acceleration", "jerk"];
    let units = ["rad/s", "rad/s²", "rad/s³"];
    let mut values = angles_rad;
    let mut first: Option<(String, usize)> = None;
    for order in 0..3 {
        values = values
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / period_s)
            .collect();
        let allowed = RATES_MAX[order] * RATE_SLACK[order];
        let excess = values.iter().position(|value| value.abs() > allowed);
        if let Some(index) = excess
            && first.as_ref().is_none_or(|(_, at)| index + order + 1 < *at)
        {
            let (name, unit, value) = (names[order], units[order], values[index]);
            first = Some((
                format!("{name} {value:.1} {unit}, allowed {}", RATES_MAX[order]),
                index + order + 1,
            ));
        }
    }
    first.map(|(text, at)| {
        let kind = if at >= end {
            "ends at speed"
        } else {
            "is not smooth"
        };
        format!("{kind}: {text}")
    })
}

#[cfg(test)]
mod tests;
