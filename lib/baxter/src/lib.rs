//! What every program here knows of a Baxter: its arms, joints and limits, what it says of its state, when a joint is at
//! rest, and how far apart its gripper's fingers are. Without ROS; metres, radians and seconds throughout.

mod aged;
mod arrival;
mod gap;
mod joint;
mod side;
mod state;

pub use aged::{Aged, Silence, fresh};
pub use arrival::{Arrival, Arrived, REST_DWELL_S, REST_VELOCITY_RAD_S};
pub use gap::Gap;
pub use joint::{JointLimits, JointSample};
pub use side::{JOINTS_PER_ARM, Side, W2, mirrored};
pub use state::{EstopButton, EstopSource, RobotState, StateRefusal, StateRules};
