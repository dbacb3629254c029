//! Converts between a gripper's own position measure and metres.

use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// Distance between the fingers of a gripper at both ends of their travel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Gap {
    /// Distance when closed, m; at least 0.
    pub closed_m: f64,
    /// Distance when open, m; more than `closed_m`.
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
    /// Checks the distances.
    ///
    /// # Errors
    /// A distance is negative or NaN, or the gripper is wider closed than open.
    pub fn validate(&self) -> Result<(), ParameterError> {
        in_range("gap/open_m", self.open_m, 0.001..=1.0, "m")?;
        in_range("gap/closed_m", self.closed_m, 0.0..=self.open_m - 1e-4, "m")
    }

    /// Distance between the fingers, m, at a share of the travel (0 closed, 1 open).
    pub fn width_m(&self, share: f64) -> f64 {
        self.closed_m + share * (self.open_m - self.closed_m)
    }

    /// Share of the travel at which the fingers are `width_m` apart. Outside 0 to 1 if the gripper cannot reach that.
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
