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
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn arrival() -> Arrival {
        Arrival::new(0.6, 0.0087, 0.02, Duration::from_millis(100))
    }

    fn sample(
        stamp_ms: u64,
        angle_rad: f64,
        velocity_rad_s: impl Into<Option<f64>>,
    ) -> JointSample {
        let stamp = Duration::from_millis(1_000_000 + stamp_ms);
        JointSample {
            angle_rad,
            velocity_rad_s: velocity_rad_s.into(),
            stamp,
        }
    }

    #[test]
    fn arrives_after_the_dwell_and_tells_since_when() {
        let mut arrival = arrival();
        assert_eq!(arrival.observe(sample(0, 0.5, 0.0)), None, "far");
        assert_eq!(arrival.observe(sample(10, 0.6, 0.5)), None, "fast");
        for stamp_ms in (20..120).step_by(10) {
            assert_eq!(
                arrival.observe(sample(stamp_ms, 0.6, 0.0)),
                None,
                "too short"
            );
        }
        let arrived = arrival.observe(sample(120, 0.601, 0.0)).unwrap();
        assert_eq!(arrived.at_rest, sample(20, 0.0, 0.0).stamp);
        assert_eq!(arrived.angle_rad, 0.601);
    }

    #[test]
    fn a_shove_during_the_dwell_starts_it_anew() {
        let mut arrival = arrival();
        arrival.observe(sample(0, 0.6, 0.0));
        arrival.observe(sample(90, 0.62, 0.1));
        assert_eq!(arrival.observe(sample(110, 0.6, 0.0)), None);
        assert!(arrival.observe(sample(210, 0.6, 0.0)).is_some());
    }

    #[test]
    fn one_sample_read_again_and_again_is_no_rest() {
        let mut arrival = arrival();
        for _ in 0..100 {
            assert_eq!(arrival.observe(sample(0, 0.6, 0.0)), None);
        }
    }

    #[test]
    fn without_velocities_two_angles_tell() {
        let mut arrival = arrival();
        for step in 0..40_u32 {
            let creeping = 0.595 + 0.0003 * f64::from(step);
            let arrived = arrival.observe(sample(u64::from(10 * step), creeping, None));
            assert_eq!(arrived, None, "0.03 rad/s is too fast");
        }
        for stamp_ms in (400..500).step_by(10) {
            assert_eq!(arrival.observe(sample(stamp_ms, 0.6067, None)), None);
        }
        assert!(arrival.observe(sample(500, 0.6067, None)).is_some());
    }

    #[test]
    fn stamps_that_jump_back_start_the_dwell_anew() {
        let mut arrival = arrival();
        arrival.observe(sample(500, 0.6, 0.0));
        assert_eq!(arrival.observe(sample(0, 0.6, 0.0)), None);
        assert_eq!(arrival.observe(sample(60, 0.6, 0.0)), None);
        assert_eq!(arrival.observe(sample(100, 0.6, 0.0)), None);
        assert!(arrival.observe(sample(160, 0.6, 0.0)).is_some());
    }

    #[test]
    fn rest_may_be_anywhere_but_must_be_rest() {
        let mut arrival = Arrival::anywhere(0.02, Duration::from_millis(100));
        assert_eq!(arrival.observe(sample(0, -2.5, 0.5)), None, "fast");
        assert_eq!(arrival.observe(sample(10, f64::NAN, 0.0)), None, "nowhere");
        assert_eq!(arrival.observe(sample(20, -2.6, 0.0)), None, "too short");
        assert_eq!(
            arrival.observe(sample(120, -2.6, 0.0)).unwrap().angle_rad,
            -2.6
        );
    }

    #[test]
    fn not_a_number_is_nowhere() {
        let mut arrival = arrival();
        for stamp_ms in (0..500).step_by(10) {
            assert_eq!(arrival.observe(sample(stamp_ms, f64::NAN, 0.0)), None);
            assert_eq!(arrival.observe(sample(stamp_ms + 5, 0.6, f64::NAN)), None);
        }
    }
}
