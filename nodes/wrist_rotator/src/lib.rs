//! Turns the wrist joint W2 of a Baxter, safely: what to command, when to refuse, when it has arrived. Without ROS.
//!
//! [`Monitor`] gathers what the robot says; [`Motion`] turns it into one command each tick, or into the reason to stop
//! commanding. Nothing here enables, resets or otherwise talks a robot into moving. Radians and seconds throughout.

mod guard;
mod monitor;
mod motion;
mod parameters;
mod trajectory;

pub use guard::{Guard, Refusal};
pub use monitor::{Monitor, Snapshot};
pub use motion::{Motion, MotionError, Step};
pub use parameters::Parameters;
pub use trajectory::Trajectory;
