//! Parameters of the calibration.

use std::path::PathBuf;

use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};

/// Parameters of the calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SweepParameters {
    /// File to which a new mount is written on request; may be empty if none is to be written.
    pub file: PathBuf,
    /// Default number of views of a sweep.
    pub view_count: u32,
    /// Time limit of a sweep, s.
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
        check_ranges! { self, "calibration/";
            view_count: 2..=64;
            deadline_s: 1.0..=3600.0, "s";
        }
        Ok(())
    }
}
