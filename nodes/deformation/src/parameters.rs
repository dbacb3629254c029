//! What a user can set.

use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

/// How deformations are measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Folder of undeformed objects, LABEL.ply or LABEL.obj, millimetres, +z up; empty: none.
    pub references: String,
    /// Standard deviation of depth 1 m away from the camera, m; it grows with the square of the distance. A D435i has
    /// 0.08 px of disparity: 0.08 / (418 px * 0.05 m).
    pub depth_sigma_at_1m_m: f64,
    /// What registration leaves between two views, standard deviation, m.
    pub registration_sigma_m: f64,
    /// A dent is at least so deep, m.
    pub depth_min_m: f64,
    /// And so many standard deviations of what the camera measures there.
    pub significance_min: f64,
    /// And so large, m^2.
    pub area_min_m2: f64,
    /// Share of the surface below which nothing is said.
    pub seen_share_min: f64,
    /// Whether the deformer is fitted to what was seen, and says what it can of what was not.
    pub synthesis: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            references: String::new(),
            depth_sigma_at_1m_m: 0.0038,
            registration_sigma_m: 0.0004,
            depth_min_m: 0.0020,
            significance_min: 2.8,
            area_min_m2: 40e-6,
            seen_share_min: 0.1,
            synthesis: true,
        }
    }
}

impl Parameters {
    /// Refuses what cannot be meant.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        in_range(
            "depth_sigma_at_1m_m",
            self.depth_sigma_at_1m_m,
            0.0..=0.1,
            "m",
        )?;
        in_range(
            "registration_sigma_m",
            self.registration_sigma_m,
            0.0..=0.01,
            "m",
        )?;
        in_range("depth_min_m", self.depth_min_m, 0.0..=0.05, "m")?;
        in_range("significance_min", self.significance_min, 0.0..=100.0, "")?;
        in_range("area_min_m2", self.area_min_m2, 0.0..=0.01, "m^2")?;
        in_range("seen_share_min", self.seen_share_min, 0.0..=1.0, "")
    }
}
