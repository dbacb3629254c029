//! The difference between the clocks of joint states and of images, as scan after scan tells it.

/// Uncertainty before the first scan, s: two computers that NTP keeps in step.
const PRIOR_SIGMA_S: f64 = 0.02;
/// How much it may change from one scan to the next, s.
const DRIFT_SIGMA_S: f64 = 0.002;

/// By how much later than their stamps say images were taken, by the joints' clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockDifference {
    /// s.
    pub offset_s: f64,
    /// Standard deviation, s.
    pub sigma_s: f64,
    /// Whether any scan has told.
    pub is_measured: bool,
}

impl Default for ClockDifference {
    fn default() -> Self {
        Self {
            offset_s: 0.0,
            sigma_s: PRIOR_SIGMA_S,
            is_measured: false,
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
        // As a Kalman filter of one number.
        let before = self.sigma_s.powi(2) + DRIFT_SIGMA_S.powi(2);
        let gain = before / (before + sigma_s.powi(2));
        self.offset_s += gain * left_s;
        self.sigma_s = ((1.0 - gain) * before).sqrt();
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

    #[test]
    fn no_measurement_changes_nothing() {
        let mut difference = ClockDifference::default();
        for (left_s, sigma_s) in [(0.01, 0.0), (f64::NAN, 0.01), (0.01, f64::NAN)] {
            difference.learn(left_s, sigma_s);
        }
        assert_eq!(difference, ClockDifference::default());
    }
}
