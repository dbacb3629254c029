//! What the hands of the simulated robot publish.

use baxter::Side;
use msg::Time;
use msg::baxter_core_msgs::{EndEffectorProperties, EndEffectorState};
use msg::reflex_msgs::{Finger, Hand as ReflexState, Motor};
use node::{Latch, Node, Publisher};
use sim_baxter::{GripperState, Hand, ReflexHand};

/// A ReFlex hand publishes at 33 Hz: each third time.
const REFLEX_DIVISOR: u64 = 3;

/// The publishers of a hand's driver.
pub enum HandPublishers {
    None,
    Electric {
        state: Publisher<EndEffectorState>,
        /// Kept: latched.
        _properties: Publisher<EndEffectorProperties>,
    },
    Reflex(Publisher<ReflexState>),
}

impl HandPublishers {
    pub fn new(node: &Node, side: Side, hand: &Hand) -> anyhow::Result<Self> {
        Ok(match hand {
            Hand::None => Self::None,
            Hand::Electric(_) => {
                let base = side.gripper_topics();
                let properties = node.publish(&format!("{base}/properties"), 1, Latch::Yes)?;
                properties.send(gripper_properties());
                Self::Electric {
                    state: node.publish(&format!("{base}/state"), 10, Latch::No)?,
                    _properties: properties,
                }
            }
            Hand::Reflex(_) => {
                let topic = format!("{}/hand_state", side.reflex_topics());
                Self::Reflex(node.publish(&topic, 10, Latch::No)?)
            }
        })
    }

    /// Publishes what is due at this tick.
    pub fn publish_due(&self, hand: &Hand, stamp: Time, tick: u64) {
        match (self, hand) {
            (Self::Electric { state, .. }, Hand::Electric(gripper)) => {
                state.send(gripper_state(gripper.state(), stamp));
            }
            (Self::Reflex(state), Hand::Reflex(hand)) if tick.is_multiple_of(REFLEX_DIVISOR) => {
                state.send(reflex_state(hand));
            }
            _ => {}
        }
    }
}

fn reflex_state(hand: &ReflexHand) -> ReflexState {
    let motor = hand.motors().map(|motor| Motor {
        joint_angle: motor.angle_rad,
        raw_angle: motor.angle_rad,
        velocity: motor.velocity_rad_s,
        load: motor.load,
        voltage: 12.0,
        temperature: 35,
        error_state: String::new(),
    });
    let [f1, f2, f3, _] = hand.motors().map(|motor| Finger {
        proximal: motor.angle_rad as f32,
        ..Default::default()
    });
    ReflexState {
        finger: [f1, f2, f3],
        motor,
    }
}

fn gripper_state(state: &GripperState, stamp: Time) -> EndEffectorState {
    EndEffectorState {
        timestamp: stamp,
        id: state.id,
        enabled: state.enabled.into(),
        calibrated: state.calibrated.into(),
        ready: state.ready.into(),
        moving: state.moving.into(),
        gripping: state.gripping.into(),
        missed: state.missed.into(),
        error: state.error.into(),
        reverse: EndEffectorState::STATE_FALSE,
        position: state.position as f32,
        force: state.force as f32,
        state: String::new(),
        command: state.command.clone(),
        command_sender: state.sender.clone(),
        command_sequence: state.sequence,
    }
}

fn gripper_properties() -> EndEffectorProperties {
    EndEffectorProperties {
        id: sim_baxter::Gripper::ID,
        ui_type: EndEffectorProperties::ELECTRIC_GRIPPER,
        manufacturer: "Rethink Research Robot".into(),
        product: "SDK End Effector, simulated".into(),
        serial_number: "0000".into(),
        hardware_rev: "1.0".into(),
        firmware_rev: "1.0".into(),
        firmware_date: "2015/01/01".into(),
        has_calibration: true,
        controls_grip: true,
        senses_grip: true,
        reverses_grip: false,
        controls_force: true,
        senses_force: true,
        controls_position: true,
        senses_position: true,
        properties: String::new(),
    }
}
