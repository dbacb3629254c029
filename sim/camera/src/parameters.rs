//! Settings of the node.

use std::path::{Path, PathBuf};

use baxter::{Gap, Side};
use gripper::HandKind;
use parameter::{ParameterError, check_ranges};
use serde::{Deserialize, Serialize};
use sim_deform::SQUEEZE_MAX_M;
use sim_objects::ObjectClass;

use crate::held::Held;
use crate::mount::Mount;
use crate::noise::NoiseParameters;
use crate::playback::CaptureFrame;

/// What the camera sees, and how well.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Arm whose hand is seen: left or right.
    pub side: Side,
    /// What is mounted there: electric or reflex.
    pub hand: HandKind,
    /// Distance between the fingers of its electric gripper at the ends of their travel.
    pub gap: Gap,
    /// Object in the hand at the start: a name, or the path of a mesh (PLY or OBJ, millimetres, +z up); empty: none.
    pub object: String,
    /// How far each finger has dented it, in metres.
    pub squeeze_m: f64,
    /// Draws the dent's place and the noise.
    pub seed: u32,
    /// Whether to measure as a real camera does; otherwise depth is exact to the millimetre.
    pub noise: bool,
    /// How good the camera is, where there is noise.
    pub noise_model: NoiseParameters,
    /// Where the camera really sits, whatever TF believes.
    pub mount: Mount,
    /// Folder of recorded captures to play instead of rendering; empty: render.
    pub captures: PathBuf,
    /// Axes of the captures.
    pub captures_frame: CapturesFrame,
    /// Images a second.
    pub rate_hz: f64,
    /// How long an exposure lasts, s; 0: no time at all. What moves meanwhile is blurred.
    pub exposure_s: f64,
    /// How much later than the middle of the exposure the stamp is, s, as by a clock that differs from the robot's.
    pub stamp_offset_s: f64,
}

/// Axes of recorded captures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CapturesFrame {
    /// PLY files are in the viewer's frame, PCD files in the optical one.
    Auto,
    /// x right, y up, z towards the viewer.
    Viewer,
    /// x right, y down, z forward.
    Optical,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            side: Side::Left,
            hand: HandKind::Electric,
            gap: Gap::default(),
            object: String::new(),
            squeeze_m: 0.0,
            seed: 1,
            noise: true,
            noise_model: NoiseParameters::default(),
            mount: Mount::default(),
            captures: PathBuf::new(),
            captures_frame: CapturesFrame::Auto,
            rate_hz: 30.0,
            exposure_s: 0.0,
            stamp_offset_s: 0.0,
        }
    }
}

impl Parameters {
    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// Names the first parameter that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        if let Held::Unknown(_) = self.held() {
            let names = ObjectClass::ALL.map(ObjectClass::name).join(", ");
            let expected = format!("empty, the path of a .ply or .obj mesh, or one of {names}");
            return Err(ParameterError::new("object", &self.object, expected));
        }
        self.gap.validate()?;
        check_ranges! { self;
            squeeze_m: 0.0..=SQUEEZE_MAX_M, "m";
            rate_hz: 1.0..=90.0, "Hz";
            exposure_s: 0.0..=0.2, "s";
            stamp_offset_s: -0.1..=0.1, "s";
        }
        self.noise_model.validate()?;
        self.mount.validate()
    }

    /// The object in the hand at the start.
    pub fn held(&self) -> Held {
        let Ok(held) = self.object.parse();
        held
    }

    /// The folder of recorded captures, if any are to be played.
    pub fn captures_folder(&self) -> Option<&Path> {
        Some(self.captures.as_path()).filter(|folder| !folder.as_os_str().is_empty())
    }

    /// The axes of all captures, unless each file's type tells.
    pub fn capture_frame(&self) -> Option<CaptureFrame> {
        match self.captures_frame {
            CapturesFrame::Auto => None,
            CapturesFrame::Viewer => Some(CaptureFrame::Viewer),
            CapturesFrame::Optical => Some(CaptureFrame::Optical),
        }
    }
}

#[cfg(test)]
mod tests;
