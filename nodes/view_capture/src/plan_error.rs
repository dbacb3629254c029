//! Scans that cannot be made.

use thiserror::Error;

/// Views of one scan at most: beyond it they lie closer than the wrist's accuracy is worth.
pub(crate) const VIEWS_MAX: usize = 64;

/// A scan that cannot be made.
#[derive(Debug, Error, PartialEq)]
pub enum PlanError {
    /// More views than the scan may have.
    #[error("{asked} views were asked for; a scan has 1 to {most}")]
    TooMany {
        /// Views asked for.
        asked: usize,
        /// Views possible.
        most: usize,
    },
    /// An angle that the wrist must not have.
    #[error(
        "an angle of {angle_rad} rad was asked for; the wrist may go from {min_rad} to {max_rad} rad"
    )]
    OutOfRange {
        /// Angle asked for, rad.
        angle_rad: f64,
        /// Smallest angle, rad.
        min_rad: f64,
        /// Largest angle, rad.
        max_rad: f64,
    },
    /// A range that the wrist cannot turn through.
    #[error(
        "a sweep through {range_rad} rad was asked for; the wrist has {min_rad} to {max_rad} rad"
    )]
    Range {
        /// Range asked for, rad.
        range_rad: f64,
        /// Smallest range, rad.
        min_rad: f64,
        /// Largest range, rad.
        max_rad: f64,
    },
    /// A sweep without kinematics.
    #[error(
        "a sweep needs the hand's pose in each image, and use_tf is false: ask for views at rest"
    )]
    NoKinematics,
    /// A rate at which images are blurred.
    #[error(
        "at {rate_rad_s} rad/s the surface {radius_m} m from the wrist's axis moves by {blur_mm:.2} mm during an exposure \
         of {exposure_s} s, more than {max_mm:.2} mm (blur_max_m): lower sweep_rate_rad_s, or the camera's exposure and \
         exposure_s with it"
    )]
    Blur {
        /// Rate of the sweep, rad/s.
        rate_rad_s: f64,
        /// Distance of the surface from the axis, m.
        radius_m: f64,
        /// Exposure, s.
        exposure_s: f64,
        /// How far the surface moves, mm.
        blur_mm: f64,
        /// How far it may, mm.
        max_mm: f64,
    },
}
