//! Where the arm may have rested in a sequence of setpoints: what the pauses between their arrivals tell of the commander.

use super::{RATE_SLACK, RATES_MAX};

/// A pause between two setpoints longer than both of these means that the arm came to rest: the next motion has to start with zero
/// velocity. In s, and in periods of the commander.
pub(super) const HOLD_S: f64 = 0.08;
const HOLD_PERIODS: f64 = 8.0;
/// Pause after which a commander may take the arm for resting, and begin from rest, periods.
const PAUSE_PERIODS: f64 = 2.5;
/// Interval between messages of a burst, s. The robot takes at most 800 commands a second.
const BURST_S: f64 = 5e-4;
/// The SDK's period of commands, s; for sequences too short to tell.
const PERIOD_S: f64 = 0.01;

/// The commander's period, s: the median of the intervals that are none of a burst.
pub(super) fn period_s(times_s: &[f64]) -> f64 {
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
pub(super) fn pauses_s(times_s: &[f64], period_s: f64) -> Vec<(f64, bool)> {
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

/// The sequence from rest, with the arm's rests where the commander paused: one for each reading of its pauses.
pub(super) fn readings(
    angles_rad: &[f64],
    pauses_s: &[(f64, bool)],
    period_s: f64,
) -> impl Iterator<Item = Vec<f64>> {
    let possible = [Possible::Always, Possible::Never, Possible::WhereBroken];
    let each = possible.into_iter().flat_map(|where_possible| {
        [true, false].map(|where_uncertain| Rests {
            where_uncertain,
            where_possible,
        })
    });
    each.map(move |rests| with_holds(angles_rad, pauses_s, period_s, rests))
}

/// The sequence in one reading.
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
