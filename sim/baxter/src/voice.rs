//! What the simulated robot says.

use baxter::Side;
use msg::Time;
use msg::baxter_core_msgs::{
    AssemblyState, CollisionAvoidanceState, CollisionDetectionState, DigitalIOState, EndpointState,
    HeadState,
};
use msg::geometry_msgs::{Point, Pose, Quaternion};
use msg::sensor_msgs::JointState;
use node::{Latch, Node, Publisher};
use sim_baxter::{JointStates, Robot};

use crate::hand_voice::HandVoice;

/// Slow topics are spoken each tenth time.
const SLOW_DIVISOR: u64 = 10;

/// The robot's publishers.
pub struct Voice {
    joint_states: Publisher<JointState>,
    state: Publisher<AssemblyState>,
    head: Publisher<HeadState>,
    arms: [ArmVoice; 2],
    hands: [HandVoice; 2],
}

struct ArmVoice {
    side: Side,
    endpoint: Publisher<EndpointState>,
    cuff: Publisher<DigitalIOState>,
    collision_avoidance: Publisher<CollisionAvoidanceState>,
    collision_detection: Publisher<CollisionDetectionState>,
}

impl Voice {
    pub fn new(node: &Node, robot: &Robot) -> anyhow::Result<Self> {
        let hand = |side| HandVoice::new(node, side, robot.hand(side));
        Ok(Self {
            // Several messages a tick share this topic.
            joint_states: node.publish("/robot/joint_states", 10, Latch::No)?,
            state: node.publish("/robot/state", 10, Latch::No)?,
            head: node.publish("/robot/head/head_state", 10, Latch::No)?,
            arms: [
                ArmVoice::new(node, Side::Left)?,
                ArmVoice::new(node, Side::Right)?,
            ],
            hands: [hand(Side::Left)?, hand(Side::Right)?],
        })
    }

    /// Publishes everything that is due at this tick.
    pub fn speak(&self, robot: &mut Robot, stamp: Time, tick: u64) {
        // Fingers first: robot_state_publisher keeps but the last message that waits for it, and where it is held up that
        // has to be the one that moves the camera and the hand.
        for fingers in Side::BOTH.map(|side| robot.finger_joint_states(side)) {
            let message = fingers.map(|fingers| joint_state(fingers, stamp));
            message
                .into_iter()
                .for_each(|message| self.joint_states.send(message));
        }
        self.joint_states
            .send(joint_state(robot.joint_states(), stamp));
        self.state
            .send(msg::robot::from_state(robot.assembly.state()));
        for (side, hand) in Side::BOTH.into_iter().zip(&self.hands) {
            hand.speak(robot.hand(side), stamp, tick);
        }
        for arm in &self.arms {
            arm.endpoint.send(endpoint_state(robot, arm.side, stamp));
            if tick.is_multiple_of(SLOW_DIVISOR) {
                arm.speak_slowly(robot, stamp);
            }
        }
        if tick.is_multiple_of(SLOW_DIVISOR) {
            self.head.send(head_state(robot));
        }
    }
}

impl ArmVoice {
    fn new(node: &Node, side: Side) -> anyhow::Result<Self> {
        let limb = side.limb_topics();
        let topic = |suffix: &str| format!("{limb}/{suffix}");
        Ok(Self {
            side,
            endpoint: node.publish(&topic("endpoint_state"), 10, Latch::No)?,
            cuff: node.publish(&side.cuff_topic(), 10, Latch::No)?,
            collision_avoidance: node.publish(
                &topic("collision_avoidance_state"),
                10,
                Latch::No,
            )?,
            collision_detection: node.publish(
                &topic("collision_detection_state"),
                10,
                Latch::No,
            )?,
        })
    }

    fn speak_slowly(&self, robot: &Robot, stamp: Time) {
        let state = robot.cuff_held(self.side) as i8;
        self.cuff.send(DigitalIOState {
            state,
            isInputOnly: true,
        });
        let mut avoidance = CollisionAvoidanceState {
            collision_object: robot.collision_objects(self.side).to_vec(),
            ..Default::default()
        };
        avoidance.header.stamp = stamp;
        self.collision_avoidance.send(avoidance);
        let mut detection = CollisionDetectionState::default();
        detection.header.stamp = stamp;
        self.collision_detection.send(detection);
    }
}

fn joint_state(states: JointStates, stamp: Time) -> JointState {
    let mut message = JointState {
        name: states.names.into_iter().map(String::from).collect(),
        position: states.positions,
        velocity: states.velocities,
        effort: states.efforts,
        ..Default::default()
    };
    message.header.stamp = stamp;
    message
}

fn endpoint_state(robot: &Robot, side: Side, stamp: Time) -> EndpointState {
    let base_from_gripper = robot.base_from_gripper(side);
    let at = base_from_gripper.translation.vector;
    let turn = base_from_gripper.rotation;
    let mut message = EndpointState {
        pose: Pose {
            position: Point {
                x: at.x,
                y: at.y,
                z: at.z,
            },
            orientation: Quaternion {
                x: turn.i,
                y: turn.j,
                z: turn.k,
                w: turn.w,
            },
        },
        ..Default::default()
    };
    message.header.stamp = stamp;
    message.header.frame_id = "base".into();
    message
}

fn head_state(robot: &Robot) -> HeadState {
    let (pan_rad, turning) = robot.head_pan();
    HeadState {
        pan: pan_rad as f32,
        isTurning: turning,
        isNodding: false,
        isPanEnabled: true,
    }
}
