//! Whether the hand stands so that a scan makes sense: upright, in the camera's view and in its range.

use nalgebra::{Isometry3, Point3, Vector3};
use thiserror::Error;

/// Where the hand must be.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseRules {
    /// How far the gripper may lean from straight up, rad.
    pub tilt_max_rad: f64,
    /// Nearest depth at which the camera measures, m.
    pub depth_min_m: f64,
    /// Farthest depth at which it does, m.
    pub depth_max_m: f64,
    /// Part of the hand's axis on which the object is: from, and to, m above the hand's origin.
    pub object_z_m: [f64; 2],
}

/// A camera's image: focal lengths, centre and size, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePlane {
    /// Focal length along x.
    pub fx: f64,
    /// Focal length along y.
    pub fy: f64,
    /// Centre, x.
    pub cx: f64,
    /// Centre, y.
    pub cy: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
}

/// What is wrong with where the hand is, and by how much.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PoseError {
    /// The gripper does not point up.
    #[error(
        "the gripper leans {tilt_deg:.1} degrees from straight up, {:.1} more than the {max_deg:.0} allowed; move the arm \
         to the scan pose", .tilt_deg - .max_deg
    )]
    Tilted {
        /// Angle between the gripper and up, degrees.
        tilt_deg: f64,
        /// Allowed angle, degrees.
        max_deg: f64,
    },
    /// Nearer or farther than the camera measures.
    #[error(
        "the object would be {depth_m:.2} m before the camera, {by_m:.2} m too {}; it must be from {min_m} to {max_m} m",
        if .depth_m < .min_m { "near" } else { "far" }
    )]
    OutOfRange {
        /// Depth of the nearest or the farthest point.
        depth_m: f64,
        /// How much it is out of range.
        by_m: f64,
        /// Nearest depth.
        min_m: f64,
        /// Farthest depth.
        max_m: f64,
    },
    /// Beside the image.
    #[error(
        "the object would be {by_px:.0} pixels beyond the {edge} edge of the image; turn the head or move the arm"
    )]
    OutOfView {
        /// The edge of the image: left, right, upper or lower.
        edge: &'static str,
        /// How far beyond it, pixels.
        by_px: f64,
    },
    /// The camera's own numbers make no sense.
    #[error(
        "camera_info has a focal length of {fx} and {fy} pixels; is the camera driver all right?"
    )]
    BadCamera {
        /// Along x.
        fx: f64,
        /// Along y.
        fy: f64,
    },
}

impl PoseRules {
    /// Checks that the gripper points up. `base_from_hand` with +z of the base up, and of the hand out along the gripper.
    ///
    /// # Errors
    /// By how much it leans too far.
    pub fn check_upright(&self, base_from_hand: &Isometry3<f64>) -> Result<(), PoseError> {
        let tilt_rad = (base_from_hand * Vector3::z()).angle(&Vector3::z());
        if tilt_rad <= self.tilt_max_rad {
            return Ok(());
        }
        Err(PoseError::Tilted {
            tilt_deg: tilt_rad.to_degrees(),
            max_deg: self.tilt_max_rad.to_degrees(),
        })
    }

    /// Checks that the whole object is in the camera's range and image. `camera_from_hand` into the optical frame (x right,
    /// y down, z forward).
    ///
    /// # Errors
    /// By how much it is too near, too far, or beyond which edge.
    pub fn check_in_view(
        &self,
        camera_from_hand: &Isometry3<f64>,
        image: &ImagePlane,
    ) -> Result<(), PoseError> {
        let (fx, fy) = (image.fx, image.fy);
        // Also refuses what is not a number.
        if !(fx > 0.0 && fy > 0.0) {
            return Err(PoseError::BadCamera { fx, fy });
        }
        let ends = self
            .object_z_m
            .map(|z_m| camera_from_hand * Point3::new(0.0, 0.0, z_m));
        ends.iter().try_for_each(|end| self.check_range(end.z))?;
        ends.iter().try_for_each(|end| image.check(end))
    }

    fn check_range(&self, depth_m: f64) -> Result<(), PoseError> {
        let (min_m, max_m) = (self.depth_min_m, self.depth_max_m);
        if (min_m..=max_m).contains(&depth_m) {
            return Ok(());
        }
        let by_m = (min_m - depth_m).max(depth_m - max_m);
        Err(PoseError::OutOfRange {
            depth_m,
            by_m,
            min_m,
            max_m,
        })
    }
}

impl ImagePlane {
    /// Checks that a point of positive depth (optical frame) is in the image.
    fn check(&self, point: &Point3<f64>) -> Result<(), PoseError> {
        let u = self.fx * point.x / point.z + self.cx;
        let v = self.fy * point.y / point.z + self.cy;
        let beyond = [
            ("left", -u),
            ("right", u - self.width),
            ("upper", -v),
            ("lower", v - self.height),
        ];
        match beyond.into_iter().find(|(_, by_px)| *by_px > 0.0) {
            Some((edge, by_px)) => Err(PoseError::OutOfView { edge, by_px }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
