//! Between a gripper's own measure and metres.

use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// How far apart the fingers of a gripper are at the ends of their travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gap {
    /// Closed, m.
    pub closed_m: f64,
    /// Open, m.
    pub open_m: f64,
}

impl Default for Gap {
    /// Baxter's electric gripper with narrow fingers in the fourth slot.
    fn default() -> Self {
        Self {
            closed_m: 0.054,
            open_m: 0.095_666,
        }
    }
}

impl Gap {
    /// Refuses a gripper that is wider closed than open.
    pub fn validate(&self) -> Result<(), ParameterError> {
        in_range("gap/open_m", self.open_m, 0.001..=1.0, "m")?;
        in_range("gap/closed_m", self.closed_m, 0.0..=self.open_m - 1e-4, "m")
    }

    /// Distance between the fingers, m, at a share of the travel (0 closed, 1 open).
    pub fn width_m(&self, share: f64) -> f64 {
        self.closed_m + share * (self.open_m - self.closed_m)
    }

    /// Share of the travel at which the fingers are `width_m` apart; outside 0 to 1 where they cannot be.
    pub fn share(&self, width_m: f64) -> f64 {
        (width_m - self.closed_m) / (self.open_m - self.closed_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_widths_are_each_others_inverse() {
        let gap = Gap::default();
        assert_eq!(gap.validate(), Ok(()));
        assert_eq!((gap.width_m(0.0), gap.width_m(1.0)), (0.054, 0.095_666));
        assert!((gap.share(gap.width_m(0.3)) - 0.3).abs() < 1e-12);
        let inside_out = Gap {
            closed_m: 0.1,
            open_m: 0.05,
        };
        assert!(inside_out.validate().is_err());
    }
}
