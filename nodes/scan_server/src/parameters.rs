//! Parameters of the node.

use baxter::Side;
use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};

/// What `~` may hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Arm whose hand holds the object: left or right.
    pub side: Side,
    /// Time for one view, from the order to turn the wrist to the view, s; more than view_capture's own deadlines together.
    pub view_deadline_s: f64,
    /// Time for the answer after the last view, s.
    pub answer_deadline_s: f64,
    /// The probability from which on a known object ends the scan before all its views are taken; 0: never.
    pub stop_when_confident: f64,
    /// Whether one scan is made as soon as clouds arrive. Meant for recorded captures: nobody waits for this scan, and it is
    /// refused where a wrist is in the graph.
    pub scan_at_start: bool,
    /// Whether the scan at the start may turn a wrist, with nobody who could stop it by going away.
    pub scan_at_start_moves_arm: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            side: Side::Left,
            view_deadline_s: 30.0,
            answer_deadline_s: 5.0,
            stop_when_confident: 0.0,
            scan_at_start: false,
            scan_at_start_moves_arm: false,
        }
    }
}

impl Parameters {
    /// Looks over all of them.
    ///
    /// # Errors
    /// Names the first that is out of range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self;
            view_deadline_s: 0.01..=600.0, "s";
            answer_deadline_s: 0.01..=600.0, "s";
            stop_when_confident: 0.0..=1.0;
        }
        Ok(())
    }

    /// Whether a scan may end before all its views are taken.
    pub fn may_end_early(&self) -> bool {
        self.stop_when_confident > 0.0
    }

    /// Whether an answer of this probability ends a scan.
    pub fn is_sure(&self, probability: f64) -> bool {
        self.may_end_early() && probability >= self.stop_when_confident
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parameter::refused_name;

    #[test]
    fn defaults_are_valid_and_bad_values_named() {
        assert_eq!(Parameters::default().validate(), Ok(()));
        let bad = |change: fn(&mut Parameters)| refused_name(Parameters::validate, change);
        assert_eq!(
            bad(|p| p.view_deadline_s = f64::NAN),
            Some("view_deadline_s")
        );
        assert_eq!(
            bad(|p| p.answer_deadline_s = -1.0),
            Some("answer_deadline_s")
        );
        let percent = bad(|p| p.stop_when_confident = 95.0);
        assert_eq!(percent, Some("stop_when_confident"));
    }

    #[test]
    fn nothing_ends_a_scan_early_unless_asked_for() {
        let mut parameters = Parameters::default();
        assert!(!parameters.may_end_early() && !parameters.is_sure(1.0));
        parameters.stop_when_confident = 0.9;
        assert!(parameters.is_sure(0.9) && !parameters.is_sure(0.89));
        assert!(!parameters.is_sure(f64::NAN));
    }
}
