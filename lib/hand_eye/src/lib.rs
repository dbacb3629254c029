//! Hand-eye calibration: estimates the camera's pose from views of the turning hand.
//!
//! Kinematics and the camera mount's calibration give the camera's pose in the hand's frame. If the mount is calibrated
//! wrongly, that pose is wrong by the same motion X in all views, as long as the camera stays on the head:
//!
//! ```text
//! actual hand_from_camera  =  hand_from_camera by kinematics · X,    X = believed_from_actual
//! ```
//!
//! With A the camera's motion between two views by kinematics, and B the one that the views show, A X = X B (Shiu and
//! Ahmad, "Calibration of wrist-mounted robotic sensors by solving homogeneous transform equations of the form AX = XB",
//! IEEE Transactions on Robotics and Automation, 1989).
//!
//! Rotations about one axis do not determine X completely: a camera that is rotated about the wrist's axis, or shifted
//! along it, sees the same. In these two directions X stays at its prior.

mod equations;
mod region;

pub use equations::{Equations, amounts, motion, prior_sigmas, turn_and_shift};
pub use region::HandRegion;

/// Standard deviation of a camera mount's rotation about each axis, rad (3°), if it was measured with a ruler and by eye.
pub const TURN_SIGMA_RAD: f64 = 0.05;
/// Standard deviation of its translation along each axis, m.
pub const SHIFT_SIGMA_M: f64 = 0.02;
/// Number of independent measurements of a surface that one view counts as. A depth camera's errors are correlated over a
/// patch of its image, so it is far less than the number of points. Chosen so that the errors of calibrations of simulated
/// sweeps agree with their covariance (camera_mount's tests compare them).
pub const PATCHES_PER_VIEW: f64 = 30.0;
