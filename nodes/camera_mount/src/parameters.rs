//! What a user can set about calibration.

use std::path::PathBuf;

use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// How the mount is calibrated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepParameters {
    /// Where a new mount is written on request; empty: nowhere.
    pub file: PathBuf,
    /// Views of a sweep unless the caller says otherwise.
    pub view_count: u32,
    /// Time for a sweep, s.
    pub deadline_s: f64,
}

impl Default for SweepParameters {
    fn default() -> Self {
        Self {
            file: PathBuf::new(),
            view_count: 8,
            deadline_s: 120.0,
        }
    }
}

impl SweepParameters {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        in_range("calibration/view_count", self.view_count, 2..=64, "")?;
        in_range("calibration/deadline_s", self.deadline_s, 1.0..=3600.0, "s")
    }
}
