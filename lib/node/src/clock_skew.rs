//! Clock skew: how far another computer's clock is from this one's, from the stamps of what it sends.
//!
//! A message that was stamped at `s` by the other clock and arrives at `a` by this one tells a - s = transit - offset. The
//! transit is not negative, and the shortest of many is at most the round trip. So the offset lies in
//! [-lag, round trip - lag], where lag is the least of the differences. This is as exact as NTP, and needs no request that the
//! robot would have to answer.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Age after which a difference is forgotten: after a clock was stepped (by NTP, say), older differences mislead.
const WINDOW: Duration = Duration::from_secs(6);
/// Number of differences that are kept at most; topics at 100 Hz need no more.
const KEPT_MAX: usize = 200;

/// Number of differences that are needed at least: a single message may have waited for a busy processor.
const KEPT_MIN: usize = 3;

/// The offset of another clock: positive where it is ahead of ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockOffset {
    /// Middle of where it may be, s.
    pub offset_s: f64,
    /// How far it may be from the middle, s; infinite where the round trip is not known.
    pub uncertainty_s: f64,
}

impl ClockOffset {
    /// The least by which the clocks differ for certain, s.
    pub fn certain_s(&self) -> f64 {
        let least_s = (self.offset_s.abs() - self.uncertainty_s).max(0.0);
        if least_s.is_finite() { least_s } else { 0.0 }
    }
}

/// The recent differences between arrival and stamp of one sender.
#[derive(Debug, Default)]
pub(crate) struct Lags {
    /// Arrival of each message, and the difference in seconds.
    recent: VecDeque<(Instant, f64)>,
}

impl Lags {
    pub fn note(&mut self, lag_s: f64, now: Instant) {
        self.recent.push_back((now, lag_s));
        while self.recent.len() > KEPT_MAX
            || self
                .recent
                .front()
                .is_some_and(|(when, _)| now.saturating_duration_since(*when) > WINDOW)
        {
            self.recent.pop_front();
        }
    }

    /// The least of the recent differences, s; `None` where too few came of late.
    pub fn least_s(&self, now: Instant) -> Option<f64> {
        let is_recent =
            |(when, _): &&(Instant, f64)| now.saturating_duration_since(*when) <= WINDOW;
        let recent = || self.recent.iter().filter(is_recent);
        let least_s = recent().map(|(_, lag_s)| *lag_s).reduce(f64::min);
        least_s.filter(|_| recent().count() >= KEPT_MIN)
    }
}

/// The offset of a clock whose messages lag by at least `lag_s`, over a link of this round trip.
pub(crate) fn offset(lag_s: f64, round_trip: Option<Duration>) -> ClockOffset {
    match round_trip {
        Some(round_trip) => {
            let half_s = round_trip.as_secs_f64() / 2.0;
            ClockOffset {
                offset_s: half_s - lag_s,
                uncertainty_s: half_s,
            }
        }
        // A message from the future is proof without a round trip.
        None if lag_s < 0.0 => ClockOffset {
            offset_s: -lag_s,
            uncertainty_s: 0.0,
        },
        None => ClockOffset {
            offset_s: 0.0,
            uncertainty_s: f64::INFINITY,
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const MS: f64 = 1e-3;

    #[test]
    fn the_offset_is_found_within_the_round_trip() {
        let (true_offset_s, round_trip) = (0.15, Duration::from_millis(4));
        for transit_s in [0.0, 1.0 * MS, 4.0 * MS] {
            let found = offset(transit_s - true_offset_s, Some(round_trip));
            assert!((found.offset_s - true_offset_s).abs() <= found.uncertainty_s + 1e-12);
            assert!((found.certain_s() - true_offset_s).abs() <= 4.0 * MS + 1e-12);
        }
    }

    #[test]
    fn a_slow_link_is_no_wrong_clock() {
        let found = offset(100.0 * MS, Some(Duration::from_millis(200)));
        assert_eq!(found.certain_s(), 0.0);
        assert_eq!(offset(5.0, None).certain_s(), 0.0, "nothing is known");
        assert_eq!(offset(-0.2, None).certain_s(), 0.2, "it is ahead");
    }

    #[test]
    fn the_least_recent_lag_counts_and_old_ones_do_not() {
        let (mut lags, begin) = (Lags::default(), Instant::now());
        assert_eq!(lags.least_s(begin), None);
        lags.note(0.03, begin);
        assert_eq!(lags.least_s(begin), None, "one is not enough");
        for lag_s in [0.001, 0.05] {
            lags.note(lag_s, begin);
        }
        assert_eq!(lags.least_s(begin), Some(0.001));
        let later = begin + WINDOW + Duration::from_secs(1);
        assert_eq!(lags.least_s(later), None);
        (0..KEPT_MIN).for_each(|_| lags.note(0.5, later));
        assert_eq!(lags.least_s(later), Some(0.5));
        (0..1000).for_each(|_| lags.note(0.1, later));
        assert!(lags.recent.len() <= KEPT_MAX);
    }
}
