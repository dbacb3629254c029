//! Parameters of the markers.

use baxter::Side;
use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};

/// How a scan is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// TF frame in which clouds stand still while the hand turns; +z is up.
    pub fixed_frame: String,
    /// Arm whose hand holds the object: left or right.
    pub side: Side,
    /// Distance beside the hand at which the views and the registered cloud are drawn, m; 0: at their true position.
    pub spread_m: f64,
    /// Height of the text above the origin of the hand, m.
    pub text_height_m: f64,
    /// Voxel size to which drawn clouds are thinned, m.
    pub voxel_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            fixed_frame: "base".into(),
            side: Side::Left,
            spread_m: 0.26,
            text_height_m: 0.44,
            voxel_m: 0.003,
        }
    }
}

impl Parameters {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// Names the first parameter that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self;
            spread_m: 0.0..=5.0, "m";
            text_height_m: -2.0..=2.0, "m";
            voxel_m: 0.001..=0.1, "m";
        }
        Ok(())
    }
}
