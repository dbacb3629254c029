//! The difference between the clocks of joint states and of images, as scan after scan tells it.
//!
//! A view that was registered wrongly tells a wrong difference. So a scan that contradicts all before it is set aside; two in a
//! row that agree with each other are believed, since then a clock was set.

/// Uncertainty before the first scan, s: two computers that NTP keeps in step.
const PRIOR_SIGMA_S: f64 = 0.02;
/// How much it may change from one scan to the next, s.
const DRIFT_SIGMA_S: f64 = 0.002;
/// A scan that tells another difference by more than so many standard deviations contradicts those before it.
const GATE_SIGMAS: f64 = 3.0;

/// By how much later than their stamps say images were taken, by the joints' clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockDifference {
    /// s.
    pub offset_s: f64,
    /// Standard deviation, s.
    pub sigma_s: f64,
    /// Whether any scan has told.
    pub is_measured: bool,
    /// What the last scan told, where it was set aside.
    set_aside: Option<Told>,
}

/// What one scan told.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Told {
    offset_s: f64,
    variance_s2: f64,
}

impl Told {
    fn contradicts(&self, other: &Self) -> bool {
        let gate_s = GATE_SIGMAS * (self.variance_s2 + other.variance_s2).sqrt();
        (self.offset_s - other.offset_s).abs() > gate_s
    }
}

impl Default for ClockDifference {
    fn default() -> Self {
        Self {
            offset_s: 0.0,
            sigma_s: PRIOR_SIGMA_S,
            is_measured: false,
            set_aside: None,
        }
    }
}

impl ClockDifference {
    /// Takes what a scan found that was left of the offset, with this one in use. Anything that is no measurement changes
    /// nothing.
    pub fn learn(&mut self, left_s: f64, sigma_s: f64) {
        if !left_s.is_finite() || !sigma_s.is_finite() || sigma_s <= 0.0 {
            return;
        }
        let told = Told {
            offset_s: self.offset_s + left_s,
            variance_s2: sigma_s.powi(2),
        };
        let mut before = Told {
            offset_s: self.offset_s,
            variance_s2: self.sigma_s.powi(2) + DRIFT_SIGMA_S.powi(2),
        };
        if self.is_measured && told.contradicts(&before) {
            match self.set_aside.replace(told) {
                Some(last) if !told.contradicts(&last) => before = last,
                _ => return,
            }
        }
        self.set_aside = None;
        // As a Kalman filter of one number.
        let gain = before.variance_s2 / (before.variance_s2 + told.variance_s2);
        self.offset_s = before.offset_s + gain * (told.offset_s - before.offset_s);
        self.sigma_s = ((1.0 - gain) * before.variance_s2).sqrt();
        self.is_measured = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scans_lead_to_the_offset_and_to_certainty() {
        let mut difference = ClockDifference::default();
        let truth_s = 0.017;
        for noise_s in [0.003, -0.004, 0.001, 0.002, -0.002] {
            let left_s = truth_s - difference.offset_s + noise_s;
            difference.learn(left_s, 0.004);
        }
        assert!(
            (difference.offset_s - truth_s).abs() < 0.003,
            "{difference:?}"
        );
        assert!(difference.sigma_s < 0.003 && difference.is_measured);
    }

    /// Scans that tell the offset with a standard deviation of 4 ms.
    fn learned(offsets_s: &[f64]) -> ClockDifference {
        let mut difference = ClockDifference::default();
        for offset_s in offsets_s {
            difference.learn(offset_s - difference.offset_s, 0.004);
        }
        difference
    }

    #[test]
    fn one_scan_that_contradicts_the_others_changes_nothing() {
        let good = [0.017, 0.013, 0.018];
        for wrong_s in [-0.05, 0.06, 0.3] {
            let difference = learned(&[&good[..], &[wrong_s]].concat());
            let same = (learned(&good).offset_s, learned(&good).sigma_s);
            assert_eq!((difference.offset_s, difference.sigma_s), same);
            let differing = learned(&[&good[..], &[wrong_s, 0.016, -wrong_s, wrong_s]].concat());
            assert!((differing.offset_s - 0.016).abs() < 0.003, "{differing:?}");
        }
    }

    #[test]
    fn a_clock_that_was_set_is_followed_from_the_second_scan_on() {
        let difference = learned(&[0.017, 0.013, 0.018, -0.024, -0.028, -0.026]);
        assert!(
            (difference.offset_s + 0.026).abs() < 0.002,
            "{difference:?}"
        );
        assert!(difference.sigma_s < 0.004);
    }

    #[test]
    fn no_measurement_changes_nothing() {
        let mut difference = ClockDifference::default();
        for (left_s, sigma_s) in [(0.01, 0.0), (f64::NAN, 0.01), (0.01, f64::NAN)] {
            difference.learn(left_s, sigma_s);
        }
        assert_eq!(difference, ClockDifference::default());
    }
}
