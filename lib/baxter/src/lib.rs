//! Facts about a Baxter, shared by all programs: arms, joints and limits, the robot's state, when a joint is at rest, how
//! the wrist turns for a scan, and the distance of the gripper's fingers. Independent of ROS; metres, radians and seconds throughout.

mod aged;
mod arrival;
mod gap;
mod joint;
mod side;
mod state;
mod wrist_plan;

pub use aged::{Aged, Silence, fresh};
pub use arrival::{Arrival, Arrived, REST_DWELL_S, REST_VELOCITY_RAD_S};
pub use gap::Gap;
pub use joint::{JointLimits, JointSample};
pub use side::{JOINTS_PER_ARM, Side, W2, mirrored};
pub use state::{EstopButton, EstopSource, RobotState, StateRefusal, StateRules};
pub use wrist_plan::WristPlan;
