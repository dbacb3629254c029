//! Parameters of the node.

use crate::answers::EarlyEnd;
use crate::stages::Wish;
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
    /// The probability from which on a known object ends a scan before all its views are taken, where the caller asked for
    /// neither views nor a range; 0: never.
    pub stop_when_confident: f64,
    /// How far the wrist must have turned between the views of an answer that ends a scan early, rad: a single view does not show
    /// that the camera mount is off.
    pub stop_turn_min_rad: f64,
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
            // In simulation, a full sweep changed none of 175 such answers (docs/scanning.md).
            stop_when_confident: 0.95,
            // With the mount 5° and 25 mm off, 4 of 100 first views were known and wrong, and none after this turn.
            stop_turn_min_rad: 0.18,
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
            stop_turn_min_rad: 0.0..=6.2, "rad";
        }
        Ok(())
    }

    /// Which running answers end the scan that is asked for; `None`: all its views are taken.
    pub fn early_end(&self, wish: Wish) -> Option<EarlyEnd> {
        (wish == Wish::default() && self.stop_when_confident > 0.0).then_some(EarlyEnd {
            probability_min: self.stop_when_confident,
            turn_min_rad: self.stop_turn_min_rad,
        })
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
    fn only_a_scan_of_no_given_views_ends_early() {
        let mut parameters = Parameters::default();
        let early_end = parameters.early_end(Wish::default());
        assert_eq!(early_end.map(|end| end.probability_min), Some(0.95));
        let swept = Wish {
            range_rad: 1.0,
            ..Default::default()
        };
        for asked in [Wish::from(3), swept] {
            assert_eq!(parameters.early_end(asked), None);
        }
        parameters.stop_when_confident = 0.0;
        assert_eq!(parameters.early_end(Wish::default()), None);
    }
}
