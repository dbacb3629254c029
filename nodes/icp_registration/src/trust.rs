//! Whether the cloud of a scan is to be trusted.

use crate::evidence::ViewEvidence;
use crate::mount::Displacement;
use crate::parameters::Parameters;

/// The views of a scan, counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Count {
    /// Views in the cloud.
    pub registered: u32,
    /// Views that were refused, and are not in it.
    pub refused: u32,
    /// The smallest fitness of a registered view: how much of it the views before have seen, 0 to 1.
    pub least_overlap: f64,
    /// Why the latest of the refused ones was.
    last_reason: String,
}

impl Default for Count {
    fn default() -> Self {
        Self {
            registered: 0,
            refused: 0,
            least_overlap: 1.0,
            last_reason: String::new(),
        }
    }
}

impl Count {
    pub(crate) fn add(&mut self, evidence: &ViewEvidence) {
        if evidence.accepted {
            self.registered += 1;
            self.least_overlap = self.least_overlap.min(evidence.fitness);
        } else {
            self.refused += 1;
            self.last_reason.clone_from(&evidence.reason);
        }
    }

    /// Why views so counted make no cloud to trust.
    pub(crate) fn doubt(&self, limits: &Parameters) -> Option<String> {
        let Self {
            registered,
            refused,
            least_overlap,
            last_reason,
        } = self;
        let all = registered + refused;
        if refused >= registered && all > 0 {
            return Some(format!(
                "{refused} of {all} views were refused, the last because {last_reason}; where the object stayed in the hand, the \
                 camera mount is off: call calibrate_camera_mount"
            ));
        }
        (*least_overlap < limits.min_overlap).then(|| {
            format!(
                "a view shares only {least_overlap:.2} of its points with those before it, below min_overlap {}; turn the \
                 wrist in smaller steps",
                limits.min_overlap
            )
        })
    }
}

impl Parameters {
    /// Why a hand that is so far from where it should be makes no cloud to trust.
    pub(crate) fn displaced(&self, hand: &Displacement) -> Option<String> {
        let Displacement {
            sideways_m,
            tilt_rad,
        } = *hand;
        let is_off = sideways_m > self.max_displacement_m || tilt_rad > self.max_tilt_rad;
        is_off.then(|| {
            format!(
                "the camera mount is off: the hand is {:.0} mm and {:.1}° from where it should be (max_displacement_m \
                 allows {:.0} mm, max_tilt_rad {:.1}°); call calibrate_camera_mount",
                1e3 * sideways_m,
                tilt_rad.to_degrees(),
                1e3 * self.max_displacement_m,
                self.max_tilt_rad.to_degrees()
            )
        })
    }
}
