//! How far apart the fingers were, and when.

use std::collections::VecDeque;
use std::time::Duration;

/// How long what the gripper said is kept: longer than any cloud takes from the camera to here.
const KEPT: Duration = Duration::from_secs(10);
/// A width that was said further than this from a time says nothing of that time.
const APART_MAX: Duration = Duration::from_secs(1);

/// What the gripper said lately, by its own stamps. So a cloud that comes late, or from a bag, meets the fingers as they
/// were when it was seen, however busy this computer is.
#[derive(Debug, Default)]
pub struct Openings {
    /// Stamp, since the epoch, and width in metres; stamps ascend.
    said: VecDeque<(Duration, f64)>,
}

impl Openings {
    /// The fingers were `width_m` apart at `stamp`. A clock that is set back, as at a bag's second round, makes what was
    /// said later void.
    pub fn hear(&mut self, stamp: Duration, width_m: f64) {
        if !width_m.is_finite() {
            return;
        }
        while self.said.back().is_some_and(|(last, _)| *last >= stamp) {
            self.said.pop_back();
        }
        self.said.push_back((stamp, width_m));
        let oldest = stamp.saturating_sub(KEPT);
        while self.said.front().is_some_and(|(first, _)| *first < oldest) {
            self.said.pop_front();
        }
    }

    /// The width nearest in time to `stamp`, in metres; None if none was said within a second of it.
    pub fn at_m(&self, stamp: Duration) -> Option<f64> {
        self.said
            .iter()
            .map(|(said, width_m)| (said.abs_diff(stamp), *width_m))
            .filter(|(apart, _)| *apart <= APART_MAX)
            .min_by_key(|(apart, _)| *apart)
            .map(|(_, width_m)| width_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: u64) -> Duration {
        Duration::from_millis(1_000_000 + millis)
    }

    #[test]
    fn a_late_cloud_meets_the_fingers_as_they_were() {
        let mut openings = Openings::default();
        for step in 0..500 {
            openings.hear(at(step * 10), 0.08 - 0.0001 * step as f64);
        }
        assert_eq!(openings.at_m(at(1_000)), Some(0.08 - 0.01));
        assert_eq!(openings.at_m(at(1_004)), Some(0.08 - 0.01));
        assert_eq!(openings.at_m(at(5_900)), Some(0.08 - 0.0499));
        assert_eq!(openings.at_m(at(6_000)), None);
    }

    #[test]
    fn what_is_old_or_void_is_forgotten() {
        let mut openings = Openings::default();
        openings.hear(at(0), 0.01);
        openings.hear(at(20_000), 0.02);
        assert_eq!(openings.at_m(at(0)), None);
        openings.hear(at(0), f64::NAN);
        assert_eq!(openings.at_m(at(20_000)), Some(0.02));
        openings.hear(at(19_900), 0.03);
        assert_eq!(openings.at_m(at(20_000)), Some(0.03));
    }
}
