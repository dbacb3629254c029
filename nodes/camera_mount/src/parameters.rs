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
    /// How far a sweep turns the wrist, rad; 0: the wrist comes to rest for each view.
    pub range_rad: f64,
    /// Views of a sweep that are used.
    pub view_count: u32,
    /// Time limit of a sweep, s.
    pub deadline_s: f64,
}

impl Default for SweepParameters {
    fn default() -> Self {
        Self {
            file: PathBuf::new(),
            range_rad: 4.2,
            view_count: 8,
            deadline_s: 120.0,
        }
    }
}

impl SweepParameters {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self, "calibration/";
            range_rad: 0.0..=6.2, "rad";
            view_count: 2..=64;
            deadline_s: 1.0..=3600.0, "s";
        }
        Ok(())
    }
}
