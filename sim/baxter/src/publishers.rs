//! What the simulated robot publishes.

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

use crate::hand_publishers::HandPublishers;

/// The slow topics (cuff, collision) are published once in this many periods.
const SLOW_DIVISOR: u64 = 10;

/// The robot's publishers.
pub struct Publishers {
    joint_states: Publisher<JointState>,
    state: Publisher<AssemblyState>,
    head: Publisher<HeadState>,
    arms: [ArmPublishers; 2],
    hands: [HandPublishers; 2],
}

struct ArmPublishers {
    side: Side,
    endpoint: Publisher<EndpointState>,
    cuff: Publisher<DigitalIOState>,
    collision_avoidance: Publisher<CollisionAvoidanceState>,
    collision_detection: Publisher<CollisionDetectionState>,
}

impl Publishers {
    pub fn new(node: &Node, robot: &Robot) -> anyhow::Result<Self> {
        let hand = |side| HandPublishers::new(node, side, robot.hand(side));
        Ok(Self {
            // Several messages a tick share this topic.
            joint_states: node.publish("/robot/joint_states", 10, Latch::No)?,
            state: node.publish("/robot/state", 10, Latch::No)?,
            head: node.publish("/robot/head/head_state", 10, Latch::No)?,
            arms: [
                ArmPublishers::new(node, Side::Left)?,
                ArmPublishers::new(node, Side::Right)?,
            ],
            hands: [hand(Side::Left)?, hand(Side::Right)?],
        })
    }

    /// Publishes everything that is due at this tick, but for what is silenced.
    pub fn publish_due(&self, robot: &mut Robot, stamp: Time, tick: u64, silenced: &str) {
        // Fingers first: robot_state_publisher keeps but the last message that waits for it, and where it is held up that
        // has to be the one that moves the camera and the hand.
        for fingers in Side::BOTH.map(|side| robot.finger_joint_states(side)) {
            let message = fingers.map(|fingers| joint_state(fingers, stamp));
            message
                .into_iter()
                .for_each(|message| self.joint_states.send(message));
        }
        if silenced != "joint_states" {
            self.joint_states
                .send(joint_state(robot.joint_states(), stamp));
        }
        if silenced != "state" {
            self.state
                .send(msg::robot::from_state(robot.assembly.state()));
        }
        for (side, hand) in Side::BOTH.into_iter().zip(&self.hands) {
            hand.publish_due(robot.hand(side), stamp, tick);
        }
        for arm in &self.arms {
            arm.endpoint.send(endpoint_state(robot, arm.side, stamp));
            if tick.is_multiple_of(SLOW_DIVISOR) {
                arm.publish_slow(robot, stamp, silenced);
            }
        }
        if tick.is_multiple_of(SLOW_DIVISOR) {
            self.head.send(head_state(robot));
        }
    }
}

impl ArmPublishers {
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

    fn publish_slow(&self, robot: &Robot, stamp: Time, silenced: &str) {
        let state = robot.cuff_held(self.side) as i8;
        if silenced != "cuff" {
            self.cuff.send(DigitalIOState {
                state,
                isInputOnly: true,
            });
        }
        let mut avoidance = CollisionAvoidanceState {
            collision_object: robot.collision_objects(self.side).to_vec(),
            ..Default::default()
        };
        avoidance.header.stamp = stamp;
        if silenced != "collision_avoidance" {
            self.collision_avoidance.send(avoidance);
        }
        let mut detection = CollisionDetectionState {
            collision_state: robot.impact(self.side),
            ..Default::default()
        };
        detection.header.stamp = stamp;
        if silenced != "collision_detection" {
            self.collision_detection.send(detection);
        }
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
