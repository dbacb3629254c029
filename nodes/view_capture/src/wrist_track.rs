//! Where the wrist was a short while ago.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use baxter::JointSample;

/// How much is remembered: longer than an image takes to come.
const REMEMBERED: Duration = Duration::from_secs(3);
/// Joint states at most, whatever their rate.
const SAMPLES_MAX: usize = 4000;
/// Over how much time a rate is measured: several joint states.
const RATE_WINDOW: Duration = Duration::from_millis(40);
/// By how much stamps must go back, or run ahead of the time that has passed, to say that a clock was set, s. Joint states come in order,
/// and held-up ones come later than their stamps, not earlier.
const STEP_MIN_S: f64 = 0.1;

/// The wrist's angles by their stamps.
#[derive(Debug, Clone, Default)]
pub struct WristTrack {
    samples: VecDeque<(Duration, f64)>,
    /// When the newest sample came.
    received: Option<Instant>,
    steps: ClockSteps,
}

/// How often the clock of the joint states was set.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ClockSteps {
    /// Times since the track began.
    pub count: u64,
    /// By how much the last time, s; positive: ahead.
    pub last_s: f64,
}

impl WristTrack {
    /// Notes a joint state and when it came, where time passes as for the robot: not while a bag is replayed. After its clock
    /// was set it is the first one.
    pub fn note(&mut self, sample: &JointSample, received: Option<Instant>) {
        if !sample.angle_rad.is_finite() {
            return;
        }
        if let Some((newest, _)) = self.samples.back() {
            let later_s = sample.stamp.as_secs_f64() - newest.as_secs_f64();
            let passed = received
                .zip(self.received)
                .map(|(now, last)| now.saturating_duration_since(last));
            let ahead_s = passed.map_or(0.0, |passed| later_s - passed.as_secs_f64());
            let step_s = if later_s < 0.0 { later_s } else { ahead_s };
            if later_s < -STEP_MIN_S || ahead_s > STEP_MIN_S {
                self.samples.clear();
                let count = self.steps.count + 1;
                self.steps = ClockSteps {
                    count,
                    last_s: step_s,
                };
            } else if later_s <= 0.0 {
                return;
            }
        }
        self.received = received;
        self.samples.push_back((sample.stamp, sample.angle_rad));
        let is_old = |(stamp, _): &(Duration, f64)| *stamp + REMEMBERED < sample.stamp;
        while self.samples.len() > SAMPLES_MAX || self.samples.front().is_some_and(is_old) {
            self.samples.pop_front();
        }
    }

    /// How often the clock of the joint states was set.
    pub fn clock_steps(&self) -> ClockSteps {
        self.steps
    }

    /// The rate up to a moment, over some 40 ms, rad/s; 0 where too little is known.
    pub fn rate_at(&self, moment: Duration) -> f64 {
        let rate = || {
            let since = moment.checked_sub(RATE_WINDOW)?;
            let turned_rad = self.at(moment)? - self.at(since)?;
            Some(turned_rad / RATE_WINDOW.as_secs_f64())
        };
        rate().unwrap_or(0.0)
    }

    /// The newest angle, rad.
    pub fn newest_rad(&self) -> Option<f64> {
        self.samples.back().map(|(_, angle_rad)| *angle_rad)
    }

    /// Whether joint states have come up to a moment.
    pub fn reaches(&self, moment: Duration) -> bool {
        self.samples
            .back()
            .is_some_and(|(stamp, _)| *stamp >= moment)
    }

    /// The angle at a moment, between the joint states before and after it, rad; `None` where they do not reach so far.
    pub fn at(&self, moment: Duration) -> Option<f64> {
        let after = self.samples.partition_point(|(stamp, _)| *stamp < moment);
        let (later, later_rad) = *self.samples.get(after)?;
        if later == moment {
            return Some(later_rad);
        }
        let (earlier, earlier_rad) = *self.samples.get(after.checked_sub(1)?)?;
        let share = moment.saturating_sub(earlier).as_secs_f64()
            / later.saturating_sub(earlier).as_secs_f64();
        Some(earlier_rad + share * (later_rad - earlier_rad))
    }
}

#[cfg(test)]
mod tests;
