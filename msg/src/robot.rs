//! What the robot says of itself, from its messages and back.

use baxter::{JointSample, RobotState};
use rosrust_msg::baxter_core_msgs::AssemblyState;
use rosrust_msg::sensor_msgs::JointState;

use crate::stamp;

/// The robot's state in a message of `/robot/state`.
pub fn state(message: &AssemblyState) -> RobotState {
    RobotState {
        ready: message.ready,
        enabled: message.enabled,
        stopped: message.stopped,
        error: message.error,
        estop_button: message.estop_button.into(),
        estop_source: message.estop_source.into(),
    }
}

/// The reverse of [`state`].
pub fn from_state(state: RobotState) -> AssemblyState {
    AssemblyState {
        ready: state.ready,
        enabled: state.enabled,
        stopped: state.stopped,
        error: state.error,
        estop_button: state.estop_button.into(),
        estop_source: state.estop_source.into(),
    }
}

/// What a message of `/robot/joint_states` says of `joint`; most messages on the topic are about others.
pub fn joint_sample(message: &JointState, joint: &str) -> Option<JointSample> {
    let stamp = stamp::since_epoch(message.header.stamp);
    JointSample::find(
        joint,
        &message.name,
        &message.position,
        &message.velocity,
        stamp,
    )
}
