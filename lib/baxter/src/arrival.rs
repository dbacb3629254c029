//! When a joint counts as arrived: near its target, slow, and both for a while.

use std::time::Duration;

use crate::joint::JointSample;

/// Speed of a joint that counts as rest unless the user says otherwise, rad/s.
pub const REST_VELOCITY_RAD_S: f64 = 0.02;

/// Dwell: time for which a joint must be that slow, s. 25 ms spans three samples of the joint states at 100 Hz, even if
/// their stamps jitter by a few ms. A longer dwell delays every view of a scan.
pub const REST_DWELL_S: f64 = 0.025;

/// Where and since when a joint has been at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrived {
    /// Last measured angle, rad.
    pub angle_rad: f64,
    /// Stamp of the first sample at rest, in ROS time.
    pub at_rest: Duration,
}

/// Decides from the samples of one joint whether it has arrived. Time is taken from the samples' stamps, so that neither
/// samples that were delayed and delivered together, nor one sample read twice, count as a long rest.
#[derive(Debug, Clone)]
pub struct Arrival {
    target_rad: f64,
    tolerance_rad: f64,
    rest_velocity_rad_s: f64,
    dwell: Duration,
    last: Option<JointSample>,
    at_rest_since: Option<Duration>,
}

impl Arrival {
    /// Arrival at `target_rad` within `tolerance_rad`, no faster than `rest_velocity_rad_s`, for `dwell`.
    pub fn new(
        target_rad: f64,
        tolerance_rad: f64,
        rest_velocity_rad_s: f64,
        dwell: Duration,
    ) -> Self {
        let (last, at_rest_since) = (None, None);
        Self {
            target_rad,
            tolerance_rad,
            rest_velocity_rad_s,
            dwell,
            last,
            at_rest_since,
        }
    }

    /// Rest at any angle: no faster than `rest_velocity_rad_s`, for `dwell`.
    pub fn anywhere(rest_velocity_rad_s: f64, dwell: Duration) -> Self {
        Self::new(0.0, f64::INFINITY, rest_velocity_rad_s, dwell)
    }

    /// Takes the newest sample. Returns where and since when the joint has been at rest, once it has arrived.
    pub fn observe(&mut self, sample: JointSample) -> Option<Arrived> {
        let last = self.last.replace(sample);
        if last.is_some_and(|last| last.stamp == sample.stamp) {
            return None;
        }
        let resting = self.is_near(sample) && self.is_slow(sample, last);
        let in_order = last.is_none_or(|last| sample.stamp > last.stamp);
        if !resting || !in_order {
            self.at_rest_since = None;
            return None;
        }
        let at_rest = *self.at_rest_since.get_or_insert(sample.stamp);
        let rested = sample.stamp.saturating_sub(at_rest);
        (rested >= self.dwell).then_some(Arrived {
            angle_rad: sample.angle_rad,
            at_rest,
        })
    }

    fn is_near(&self, sample: JointSample) -> bool {
        (sample.angle_rad - self.target_rad).abs() <= self.tolerance_rad
    }

    /// Whether the joint is slow, by its reported velocity, or by the difference of two angles where the message has none.
    fn is_slow(&self, sample: JointSample, last: Option<JointSample>) -> bool {
        let velocity_rad_s = match (sample.velocity_rad_s, last) {
            (Some(velocity_rad_s), _) => velocity_rad_s,
            (None, Some(last)) if sample.stamp > last.stamp => {
                let elapsed_s = sample.stamp.saturating_sub(last.stamp).as_secs_f64();
                (sample.angle_rad - last.angle_rad) / elapsed_s
            }
            _ => return false,
        };
        velocity_rad_s.abs() <= self.rest_velocity_rad_s
    }
}

#[cfg(test)]
mod tests;
