//! Rate limit for measuring the answers of a scan that still runs. The next view replaces such an answer, and the measurement takes
//! processor time from the stages that make the complete answer, for which somebody waits.

use std::time::{Duration, Instant};

/// The pause after a measurement, in multiples of its duration: 3 limits the measurements to a quarter of one processor core.
const PAUSE: u32 = 3;

/// When the next running answer is measured.
pub struct Pace {
    due: Instant,
}

impl Pace {
    /// The next one, from a moment on.
    pub fn new(due: Instant) -> Self {
        Self { due }
    }

    /// Whether a running answer is measured that came at a moment.
    pub fn is_due(&self, now: Instant) -> bool {
        now >= self.due
    }

    /// Notes what a measurement took that has just ended.
    pub fn note(&mut self, took: Duration, now: Instant) {
        self.due = now + PAUSE * took;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_answers_take_a_quarter_of_the_time_at_most() {
        let (begun, took) = (Instant::now(), Duration::from_millis(20));
        let mut pace = Pace::new(begun);
        let (mut now, mut measured, mut passed_over) = (begun, 0, 0);
        while now < begun + Duration::from_secs(4) {
            if pace.is_due(now) {
                now += took;
                pace.note(took, now);
                measured += 1;
            } else {
                now += Duration::from_millis(1);
                passed_over += 1;
            }
        }
        assert_eq!((measured, passed_over), (50, 50 * 60));
    }
}
