//! A simulated Baxter: its kinematics, its arm, its state machine and its hands, without ROS.
//!
//! [`Robot`] is the whole machine. Time enters by [`Robot::step`] alone, so that tests need no clock. It is meant to be as
//! strict as the real robot: it moves only while enabled, never faster than the joint limits times the speed ratio, and
//! holds still when its commander falls silent. It also judges whether the commander keeps the contract of motion
//! ([`Robot::take_violations`]). Metres, radians, seconds throughout.

mod arm;
mod assembly;
mod contract;
mod gripper;
mod gripper_command;
mod hand;
mod kinematics;
mod parameters;
mod reflex;
mod robot;
mod scan_pose;
mod sensors;
mod tracker;
mod urdf;

pub use arm::{Arm, CommandError, CommandMode};
pub use assembly::Assembly;
pub use gripper::{Gripper, GripperState};
pub use gripper_command::{GripperCommand, GripperCommandError};
pub use hand::{Hand, HandKind};
pub use kinematics::{Chain, Kinematics};
pub use parameters::Parameters;
pub use reflex::{REFLEX_MOTORS, ReflexHand, ReflexMotor};
pub use robot::Robot;
pub use scan_pose::{ScanPose, ScanPoseError};
pub use sensors::JointStates;
pub use urdf::{Joint, JointKind, Limits, Urdf, UrdfError};
