//! Hand-eye calibration: what views of the turning hand say about where the camera sits.
//!
//! Kinematics and the camera mount's calibration say where the camera is in the hand's frame. Where the mount is off, they
//! are wrong by one and the same motion X in all views, as long as the camera stays on the head:
//!
//! ```text
//! hand_from_camera, where it is  =  hand_from_camera by kinematics · X,    X = believed_from_actual
//! ```
//!
//! With A the camera's motion between two views by kinematics, and B the one that the views show, A X = X B (Shiu and
//! Ahmad, "Calibration of wrist-mounted robotic sensors by solving homogeneous transform equations of the form AX = XB",
//! IEEE Transactions on Robotics and Automation, 1989).
//!
//! Turns about one axis do not determine X: a camera that is turned about the wrist's axis, or shifted along it, sees the
//! same. There X stays at its prior.

mod equations;
mod region;

pub use equations::{Equations, amounts, motion, prior_sigmas, turn_and_shift};
pub use region::HandRegion;

/// A camera mount measured with a ruler and by eye is off by this angle about each axis, rad, one standard deviation (3°).
pub const TURN_SIGMA_RAD: f64 = 0.05;
/// The same along each axis, m.
pub const SHIFT_SIGMA_M: f64 = 0.02;
/// A depth camera's errors are alike over a patch of its image, so that neighbouring points tell the same: a view counts
/// as this many independent measurements of a surface. With it, calibrations of simulated sweeps are off by what their
/// covariance claims (camera_mount's tests compare them).
pub const PATCHES_PER_VIEW: f64 = 30.0;
