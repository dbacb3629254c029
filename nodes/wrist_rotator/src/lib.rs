//! Turns the wrist joint W2 of a Baxter, safely: what to command, when to refuse, when it has arrived. Without ROS.
//!
//! [`Monitor`] gathers what the robot says; [`Motion`] turns it into one command each tick, from the first to the rest of the
//! arm. Nothing here enables, resets or otherwise talks a robot into moving. Radians and seconds throughout.
//!
//! # The contract of motion
//!
//! The arm moves only while
//! - (a) somebody who asked is alive and waits, through all hands that the request passes;
//! - (b) everything that may forbid motion is heard and fresh ([`Guard`]);
//! - (c) nobody else commands the arm;
//! - (d) the setpoints are within limits of position, velocity, acceleration and jerk, from the first to the last, holds and
//!   stops included ([`Setpoints`]).
//!
//! When any of it ends, the arm comes to rest along a ramp within 0.25 s ([`Motion::end`]), whoever asked is told why, and
//! the next request works. A robot that itself no longer takes commands (emergency stop, disabled, cuff held) gets none at
//! once: a ramp would go on in vain, and move the arm should it take commands again meanwhile.

mod guard;
mod monitor;
mod motion;
mod parameters;
mod refusal;
mod setpoints;

pub use guard::Guard;
pub use monitor::{Monitor, Snapshot};
pub use motion::{ConstantPart, Ended, Motion, MotionError, Step, Turn};
pub use parameters::{Parameters, Surroundings};
pub use refusal::Refusal;
pub use setpoints::{NoPath, RateLimits, Setpoint, Setpoints};
