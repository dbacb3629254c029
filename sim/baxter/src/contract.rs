//! Whether whoever commands an arm keeps the contract of motion, as far as the robot can see: setpoints within limits from the
//! first to the last, and none while something forbids motion. That somebody waits for the motion a robot cannot see.

use std::collections::BTreeSet;

use baxter::{JOINTS_PER_ARM, JointLimits, Side};

/// Largest rates of change of setpoints: rad/s, rad/s², rad/s³. Those within which `wrist_rotator` stops; on its way to a target
/// it stays well below. The velocity is W2's 4 rad/s times the usual speed ratio of 0.3.
const RATES_MAX: [f64; 3] = [1.2, 10.0, 250.0];
/// What rounding and a wrong estimate of the commander's period add to velocity, acceleration and jerk, as factors.
const RATE_SLACK: [f64; 3] = [1.1, 1.25, 1.5];
/// Pause between two setpoints after which the arm has come to rest in between, and has to be moved from rest, s and periods.
const HOLD_S: f64 = 0.08;
const HOLD_PERIODS: f64 = 8.0;
/// Pause after which a commander may take the arm for resting, and begin from rest, periods.
const PAUSE_PERIODS: f64 = 2.5;
/// Pause after which the robot has let go of the last setpoint, s: the timeout of position mode.
const LET_GO_S: f64 = 0.2;
/// Distance of a first setpoint from the arm, rad.
const START_ERROR_MAX_RAD: f64 = 0.05;
/// How long setpoints may come after something has come to forbid them, s: a period of the slowest topic that says so
/// (0.1), the time in which the arm has to rest (0.25), and what a busy computer adds.
const REACTION_S: f64 = 0.5;
/// Interval between messages of a burst, s. The robot takes at most 800 commands a second.
const BURST_S: f64 = 5e-4;
/// The SDK's period of commands, s; for sequences too short to tell.
const PERIOD_S: f64 = 0.01;

/// Angles of some of an arm's joints, rad, in the robot's order.
pub(crate) type Setpoint = [Option<f64>; JOINTS_PER_ARM];

/// Watches one arm.
#[derive(Debug, Clone)]
pub(crate) struct Contract {
    side: Side,
    limits: [JointLimits; JOINTS_PER_ARM],
    /// Setpoints and the times of their arrival, s, since the arm last rested without.
    sequence: Vec<(f64, Setpoint)>,
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

    fn close_when_silent(&mut self, time_s: f64) {
        let last_s = self.sequence.last().map(|(last_s, _)| *last_s);
        if last_s.is_some_and(|last_s| time_s - last_s > LET_GO_S) {
            self.close();
        }
    }

    /// Judges the setpoints since the arm last rested without.
    fn close(&mut self) {
        let sequence = std::mem::take(&mut self.sequence);
        let cut = std::mem::take(&mut self.cut);
        let times_s: Vec<f64> = sequence.iter().map(|(time_s, _)| *time_s).collect();
        let period_s = period_s(&times_s);
        let pauses_s = pauses_s(&times_s, period_s);
        for joint in 0..JOINTS_PER_ARM {
            let angles_rad: Option<Vec<f64>> = sequence
                .iter()
                .map(|(_, setpoint)| setpoint[joint])
                .collect();
            let Some(angles_rad) = angles_rad else {
                continue;
            };
            let excess = |(where_uncertain, where_possible)| {
                let rests = Rests {
                    where_uncertain,
                    where_possible,
                };
                let held_rad = with_holds(&angles_rad, &pauses_s, period_s, rests);
                excess(held_rad, !cut, period_s)
            };
            // In doubt for the commander: against the contract is what no reading of its pauses makes smooth.
            let possible = [Possible::Always, Possible::Never, Possible::WhereBroken];
            let readings = possible.map(|possible| [(true, possible), (false, possible)]);
            let readings = readings.into_iter().flatten();
            let excesses: Option<Vec<String>> = readings.map(excess).collect();
            if let Some(first) = excesses.and_then(|excesses| excesses.into_iter().next()) {
                self.violate(format!("{} {first}", self.name(joint)));
            }
        }
    }
}

/// The commander's period, s: the median of the intervals that are none of a burst.
fn period_s(times_s: &[f64]) -> f64 {
    let intervals_s = times_s.windows(2).map(|pair| pair[1] - pair[0]);
    let mut intervals_s: Vec<f64> = intervals_s
        .filter(|interval_s| *interval_s > BURST_S)
        .collect();
    intervals_s.sort_by(f64::total_cmp);
    match intervals_s.get(intervals_s.len() / 2) {
        Some(median_s) if intervals_s.len() >= 8 => *median_s,
        _ => PERIOD_S,
    }
}

/// The pauses of the commander before each setpoint, s, and whether they are certain: setpoints that were held up on the way
/// arrive in a burst, though sent one period apart.
fn pauses_s(times_s: &[f64], period_s: f64) -> Vec<(f64, bool)> {
    let mut sent_s = times_s.to_vec();
    for index in (1..sent_s.len()).rev() {
        sent_s[index - 1] = sent_s[index - 1].min(sent_s[index] - period_s);
    }
    let mut pauses_s = vec![(0.0, true)];
    for (index, pair) in sent_s.windows(2).enumerate() {
        // A burst may be too short to tell how long it was held up.
        let next = times_s
            .get(index + 2)
            .map(|next_s| next_s - times_s[index + 1]);
        let is_certain = next.is_some_and(|next_s| next_s >= period_s / 2.0);
        pauses_s.push((pair[1] - pair[0], is_certain));
    }
    pauses_s
}

/// Which pauses of a commander are taken for rests of the arm.
#[derive(Debug, Clone, Copy)]
struct Rests {
    /// Those whose length a burst leaves uncertain.
    where_uncertain: bool,
    /// Those after which the commander may have begun anew, or gone on.
    where_possible: Possible,
}

/// Which of the pauses that may be rests are taken for rests.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Possible {
    Always,
    Never,
    /// Only those after which the setpoints do not go on smoothly.
    WhereBroken,
}

/// The sequence from rest, with the arm's rests where the commander paused.
fn with_holds(
    angles_rad: &[f64],
    pauses_s: &[(f64, bool)],
    period_s: f64,
    rests: Rests,
) -> Vec<f64> {
    // The first step from rest, and no more.
    let step_max_rad = RATES_MAX[2] * RATE_SLACK[2] * period_s.powi(3);
    let first = angles_rad.first();
    let mut held_rad: Vec<f64> = first.map(|first| vec![*first; 3]).unwrap_or_default();
    for (angle_rad, (pause_s, is_certain)) in angles_rad.iter().zip(pauses_s) {
        let last_rad = held_rad.last().copied().unwrap_or(*angle_rad);
        let begins_anew = (angle_rad - last_rad).abs() <= step_max_rad;
        let must_rest = *pause_s > HOLD_S.max(HOLD_PERIODS * period_s);
        let may_rest = begins_anew && *pause_s > PAUSE_PERIODS * period_s;
        let is_taken = match rests.where_possible {
            Possible::Always => true,
            Possible::Never => false,
            Possible::WhereBroken => !goes_on_smoothly(&held_rad, *angle_rad, period_s),
        };
        let is_rest = must_rest || (may_rest && is_taken);
        if is_rest && (*is_certain || rests.where_uncertain) {
            // That the arm was not slowed down before is not judged: a commander without processor time cannot.
            held_rad.push(f64::NAN);
            held_rad.extend([last_rad; 3]);
        }
        held_rad.push(*angle_rad);
    }
    held_rad
}

/// Whether the next setpoint keeps the limit of jerk, without a rest before it.
fn goes_on_smoothly(held_rad: &[f64], next_rad: f64, period_s: f64) -> bool {
    let [.., a_rad, b_rad, c_rad] = held_rad else {
        return true;
    };
    let jerk_rad_s3 = (next_rad - 3.0 * c_rad + 3.0 * b_rad - a_rad) / period_s.powi(3);
    // False also where a rest lies between: NaN.
    jerk_rad_s3.abs() <= RATES_MAX[2] * RATE_SLACK[2]
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
mod tests {
    use super::*;

    fn violations(angles_rad: &[f64], pause: impl Fn(usize) -> f64) -> String {
        let mut contract = Contract::new(Side::Left);
        let mut time_s = 1.0;
        let mut arm_rad = [0.0; JOINTS_PER_ARM];
        for (index, angle_rad) in angles_rad.iter().enumerate() {
            let mut setpoint = Setpoint::default();
            setpoint[6] = Some(*angle_rad);
            contract.receive(setpoint, &arm_rad, time_s);
            arm_rad[6] = *angle_rad;
            time_s += pause(index);
        }
        contract.forbid(None, true, time_s + 1.0);
        contract.take_violations().join("; ")
    }

    /// From rest to rest with a cosine: at most 0.79 rad/s, 2.5 rad/s².
    fn smooth() -> Vec<f64> {
        let turned =
            |tick: i32| 0.25 - 0.25 * (std::f64::consts::PI * f64::from(tick) / 100.0).cos();
        (0..=100).map(turned).collect()
    }

    #[test]
    fn smooth_setpoints_are_none_even_where_they_arrive_in_bursts() {
        assert_eq!(violations(&smooth(), |_| 0.01), "");
        let bursts = |index| if index % 10 == 9 { 0.1 } else { 0.0 };
        let periodic = |index| if index < 50 { 0.01 } else { bursts(index) };
        assert_eq!(violations(&smooth(), periodic), "");
    }

    #[test]
    fn jumps_and_abrupt_ends_are_named() {
        let mut jump = smooth();
        jump.extend([0.52; 5]);
        let text = violations(&jump, |_| 0.01);
        assert!(text.contains("left_w2 is not smooth"), "{text}");
        let text = violations(&smooth()[..50], |_| 0.01);
        assert!(text.contains("left_w2 ends at speed"), "{text}");
        let text = violations(&[0.2; 5], |_| 0.01);
        assert!(text.contains("begins 0.200 rad from the arm"), "{text}");
        let text = violations(&[3.2; 5], |_| 0.01);
        assert!(text.contains("commanded to 3.200 rad"), "{text}");
    }

    #[test]
    fn going_on_at_speed_after_a_pause_is_a_jump() {
        let text = violations(&smooth(), |index| if index == 50 { 0.15 } else { 0.01 });
        assert!(text.contains("is not smooth"), "{text}");
    }

    #[test]
    fn what_forbids_motion_ends_it() {
        let mut contract = Contract::new(Side::Left);
        let setpoint = [Some(0.0); JOINTS_PER_ARM];
        let arm_rad = [0.0; JOINTS_PER_ARM];
        contract.forbid(Some("the cuff is held"), false, 1.0);
        contract.receive(setpoint, &arm_rad, 1.4);
        assert_eq!(contract.take_violations(), Vec::<String>::new());
        contract.forbid(Some("the cuff is held"), false, 1.5);
        contract.receive(setpoint, &arm_rad, 1.6);
        assert_eq!(
            contract.take_violations(),
            ["left arm: commanded although the cuff is held"]
        );
    }
}
