//! Where the wrist was a short while ago.

use std::collections::VecDeque;
use std::time::Duration;

use baxter::JointSample;

/// How much is remembered: longer than an image takes to come.
const REMEMBERED: Duration = Duration::from_secs(3);
/// Joint states at most, whatever their rate.
const SAMPLES_MAX: usize = 4000;
/// Over how much time a rate is measured: several joint states.
const RATE_WINDOW: Duration = Duration::from_millis(40);
/// A stamp so far before the newest one belongs to another past.
const JUMP: Duration = Duration::from_secs(1);

/// The wrist's angles by their stamps.
#[derive(Debug, Clone, Default)]
pub struct WristTrack {
    samples: VecDeque<(Duration, f64)>,
}

impl WristTrack {
    /// Notes a joint state. After a jump back in time it is the first one.
    pub fn note(&mut self, sample: &JointSample) {
        if !sample.angle_rad.is_finite() {
            return;
        }
        if let Some((newest, _)) = self.samples.back() {
            if sample.stamp + JUMP < *newest {
                self.samples.clear();
            } else if sample.stamp <= *newest {
                return;
            }
        }
        self.samples.push_back((sample.stamp, sample.angle_rad));
        let is_old = |(stamp, _): &(Duration, f64)| *stamp + REMEMBERED < sample.stamp;
        while self.samples.len() > SAMPLES_MAX || self.samples.front().is_some_and(is_old) {
            self.samples.pop_front();
        }
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
mod tests {
    use super::*;

    fn sample(stamp_ms: u64, angle_rad: f64) -> JointSample {
        JointSample {
            angle_rad,
            velocity_rad_s: None,
            stamp: Duration::from_millis(stamp_ms),
        }
    }

    fn at(track: &WristTrack, moment_ms: u64) -> Option<f64> {
        track.at(Duration::from_millis(moment_ms))
    }

    #[test]
    fn angles_are_interpolated_between_joint_states_and_not_beyond() {
        let mut track = WristTrack::default();
        for (stamp_ms, angle_rad) in [(1000, 0.0), (1010, 0.01), (1030, 0.05), (1020, 9.0)] {
            track.note(&sample(stamp_ms, angle_rad));
        }
        assert_eq!(at(&track, 1000), Some(0.0));
        assert!(at(&track, 1020).is_some_and(|angle_rad| (angle_rad - 0.03).abs() < 1e-12));
        assert_eq!((at(&track, 999), at(&track, 1031)), (None, None));
        assert!((track.rate_at(Duration::from_millis(1030)) - 0.0).abs() < 1e-12);
        track.note(&sample(1040, 0.07));
        assert!((track.rate_at(Duration::from_millis(1040)) - 1.75).abs() < 1e-9);
        assert!(track.reaches(Duration::from_millis(1030)));
        assert!(!track.reaches(Duration::from_millis(1041)));
    }

    #[test]
    fn what_is_old_or_of_another_past_is_forgotten() {
        let mut track = WristTrack::default();
        (0..1000).for_each(|index| track.note(&sample(10 * index, 1.0)));
        assert!(track.samples.len() <= 301);
        assert_eq!(at(&track, 100), None);
        track.note(&sample(50, 2.0));
        track.note(&sample(60, f64::NAN));
        assert_eq!((at(&track, 50), track.samples.len()), (Some(2.0), 1));
    }
}
