//! Opens and closes a gripper, and reports what its fingers met. Independent of ROS.
//!
//! A [`Hand`] is a protocol as a state machine: its inputs are messages and the time, its outputs are commands. There are
//! two, [`Electric`] (Baxter's electric gripper) and [`Reflex`] (a ReFlex hand). Metres, radians, seconds; forces are shares
//! of the gripper's largest.

mod electric;
mod error;
mod hand;
mod parameters;
mod reflex;

pub use electric::{Electric, ElectricCommand, ElectricState, Flag};
pub use error::GraspError;
pub use hand::{Goal, Grasped, Hand, Outcome, Step, Task};
pub use parameters::{ElectricParameters, HandKind, Parameters, ReflexParameters};
pub use reflex::{FINGERS, FingerState, PoseCommand, Reflex};
