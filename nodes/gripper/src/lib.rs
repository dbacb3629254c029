//! Opens and closes a gripper, and says what its fingers met. Without ROS.
//!
//! A [`Hand`] is a protocol as a state machine: it is told what arrives and what time it is, and says what to send. There
//! are two, [`Electric`] (Baxter's electric gripper) and [`Reflex`] (a ReFlex hand). Metres, radians, seconds; forces are
//! shares of the gripper's largest.

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
