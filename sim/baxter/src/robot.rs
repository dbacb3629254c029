//! The whole robot.

use baxter::{Side, mirrored};
use nalgebra::Isometry3;

use crate::arm::{Arm, CommandError};
use crate::assembly::Assembly;
use crate::contract::Contract;
use crate::gripper::Gripper;
use crate::hand::{Hand, HandKind};
use crate::kinematics::{Chain, Kinematics, arm_positions};
use crate::parameters::Parameters;
use crate::reflex::ReflexHand;
use crate::scan_pose::ScanPoseError;
use crate::sensors::{Encoders, JointStates};
use crate::tracker::{Goal, Tracker};
use crate::urdf::UrdfError;

/// The controller's period, as the real robot's.
const STEP_MAX_S: f64 = 1e-3;
/// Where an arm rests that does not scan: at the robot's side, out of the camera's view; the right one, in the robot's order,
/// rad.
const RIGHT_ARM_AT_REST_RAD: [f64; 7] = [0.08, -1.0, 1.19, 1.94, -0.67, 1.03, 0.5];
/// What a real robot reports for its fixed torso joint, rad.
const TORSO_T0_RAD: f64 = -12.566;
/// Acceleration of the head, rad/s^2. Assumed.
const HEAD_ACCELERATION_RAD_S2: f64 = 10.0;

/// A simulated Baxter. [`Robot::step`] moves time on; the rest are its sensors and its commands.
#[derive(Debug, Clone)]
pub struct Robot {
    /// State machine; its methods are the buttons and the `set_super_*` topics.
    pub assembly: Assembly,
    hands: [Hand; 2],
    arms: [Arm; 2],
    head: Tracker,
    head_goal: Goal,
    cuffs_held: [bool; 2],
    collision_objects: [Vec<String>; 2],
    impacts: [bool; 2],
    contracts: [Contract; 2],
    time_s: f64,
    base_from_gripper: [Chain; 2],
    encoders: Encoders,
}

impl Robot {
    /// A robot at rest in the scan pose.
    ///
    /// # Errors
    /// The pose is out of the joint limits, or the description lacks a joint or a link of the robot.
    pub fn new(parameters: &Parameters, kinematics: &Kinematics) -> Result<Self, ScanPoseError> {
        let pose = &parameters.scan_pose;
        pose.validate(kinematics)?;
        let arm = |side| -> Result<Arm, UrdfError> {
            let limits = kinematics.arm_limits(side)?;
            let angles_rad = match (side, side == parameters.side) {
                (Side::Left, true) => pose.left_arm(),
                (Side::Right, true) => mirrored(pose.left_arm()),
                (Side::Left, false) => mirrored(RIGHT_ARM_AT_REST_RAD),
                (Side::Right, false) => RIGHT_ARM_AT_REST_RAD,
            };
            Ok(Arm::new(side.joint_names(), limits, angles_rad, parameters))
        };
        let finger = kinematics.limits("l_gripper_l_finger_joint")?;
        let hand = |kind| match kind {
            HandKind::None => Hand::None,
            HandKind::Reflex => Hand::Reflex(ReflexHand::default()),
            HandKind::Electric => Hand::Electric(Gripper::new(
                parameters.gripper_closed_gap_m,
                finger.upper - finger.lower,
                parameters.gripper_calibrated,
            )),
        };
        let mut robot = Self {
            assembly: Assembly::new(
                parameters.enabled,
                parameters.reports_ready,
                parameters.enabling_s,
            ),
            hands: [parameters.left_hand, parameters.right_hand].map(hand),
            arms: [arm(Side::Left)?, arm(Side::Right)?],
            head: Tracker::new(
                match parameters.side {
                    Side::Left => pose.head_pan_rad,
                    Side::Right => -pose.head_pan_rad,
                },
                kinematics.limits("head_pan")?,
                HEAD_ACCELERATION_RAD_S2,
            ),
            head_goal: Goal::Hold,
            cuffs_held: [false; 2],
            collision_objects: Default::default(),
            impacts: [false; 2],
            contracts: Side::BOTH.map(Contract::new),
            time_s: 0.0,
            base_from_gripper: [
                kinematics.chain("left_gripper")?,
                kinematics.chain("right_gripper")?,
            ],
            encoders: Encoders::new(
                parameters.seed,
                parameters.position_noise_rad,
                parameters.velocity_noise_rad_s,
            ),
        };
        for hand in &mut robot.hands {
            hand.step(1e-9, parameters.enabled);
        }
        Ok(robot)
    }

    /// Moves time on by `dt_s`, in controller periods of at most 1 ms.
    pub fn step(&mut self, dt_s: f64) {
        if dt_s <= 0.0 {
            return;
        }
        let periods = (dt_s / STEP_MAX_S).ceil().max(1.0);
        for _ in 0..periods as usize {
            self.step_once(dt_s / periods);
        }
    }

    /// An arm.
    pub fn arm(&self, side: Side) -> &Arm {
        &self.arms[side as usize]
    }

    /// An arm, for its speed ratio and command timeout.
    pub fn arm_mut(&mut self, side: Side) -> &mut Arm {
        &mut self.arms[side as usize]
    }

    /// What is mounted on a wrist.
    pub fn hand(&self, side: Side) -> &Hand {
        &self.hands[side as usize]
    }

    /// What is mounted on a wrist, for its commands.
    pub fn hand_mut(&mut self, side: Side) -> &mut Hand {
        &mut self.hands[side as usize]
    }

    /// A joint command as it arrives: mode, names and numbers (rad or rad/s), for all or some of an arm's joints.
    ///
    /// # Errors
    /// The robot is not enabled, the cuff is held, or the command is malformed; then it changes nothing.
    pub fn command_arm(
        &mut self,
        side: Side,
        mode: i32,
        names: &[String],
        values: &[f64],
    ) -> Result<(), CommandError> {
        let angles_rad = self.arm(side).angles_rad();
        if let Some(setpoint) = self.arm(side).setpoint(mode, names, values) {
            self.contracts[side as usize].receive(setpoint, &angles_rad, self.time_s);
        }
        if !self.assembly.allows_motion() {
            return Err(CommandError::NotEnabled);
        }
        if self.cuff_held(side) {
            return Err(CommandError::CuffHeld);
        }
        self.arm_mut(side).command(mode, names, values)
    }

    /// Turns the head to `target_rad` (clipped to its range) at a fraction of its speed; ignored if not finite.
    pub fn command_head(&mut self, target_rad: f64, speed_ratio: f64) {
        if target_rad.is_finite() && speed_ratio.is_finite() && self.assembly.allows_motion() {
            let speed = speed_ratio.clamp(0.0, 1.0);
            self.head_goal = Goal::Position {
                target: target_rad,
                speed,
            };
        }
    }

    /// Angle (rad) of the head, and whether it is turning.
    pub fn head_pan(&self) -> (f64, bool) {
        (self.head.position, self.head.velocity.abs() > 1e-3)
    }

    /// Does a person hold the cuff?
    pub fn cuff_held(&self, side: Side) -> bool {
        self.cuffs_held[side as usize]
    }

    /// Takes or releases the cuff. While it is held the arm ignores commands.
    pub fn hold_cuff(&mut self, side: Side, held: bool) {
        self.cuffs_held[side as usize] = held;
    }

    /// What collision avoidance sees too near; empty if nothing.
    pub fn collision_objects(&self, side: Side) -> &[String] {
        &self.collision_objects[side as usize]
    }

    /// Whether collision detection feels an impact on an arm.
    pub fn impact(&self, side: Side) -> bool {
        self.impacts[side as usize]
    }

    /// Sets what collision detection feels.
    pub fn set_impact(&mut self, side: Side, impact: bool) {
        self.impacts[side as usize] = impact;
    }

    /// What the commanders of the arms have done against the contract of motion since this was asked last, in words. A
    /// motion is judged when it has ended: 0.2 s after its last setpoint.
    pub fn take_violations(&mut self) -> Vec<String> {
        let violations = self.contracts.iter_mut().map(Contract::take_violations);
        violations.flatten().collect()
    }

    /// Sets what collision avoidance sees.
    pub fn set_collision_objects(&mut self, side: Side, objects: Vec<String>) {
        self.collision_objects[side as usize] = objects;
    }

    /// True frame of the fingertips (`left_gripper`, `right_gripper`) in `base`, as endpoint_state reports it.
    pub fn base_from_gripper(&self, side: Side) -> Isometry3<f64> {
        let angles_rad = self.arm(side).angles_rad();
        self.base_from_gripper[side as usize].base_from_link(arm_positions(side, &angles_rad))
    }

    /// The 17 joints of head, arms and torso in alphabetical order, as the encoders read them now.
    pub fn joint_states(&mut self) -> JointStates {
        let mut joints = vec![("head_nod", 0.0, 0.0)];
        joints.push(("head_pan", self.head.position, self.head.velocity));
        for arm in &self.arms {
            let moving = arm.angles_rad().into_iter().zip(arm.velocities_rad_s());
            let named = arm.names().into_iter().zip(moving);
            joints.extend(named.map(|(name, (angle, velocity))| (name, angle, velocity)));
        }
        for (_, position, velocity) in &mut joints[1..] {
            (*position, *velocity) = self.encoders.read(*position, *velocity);
        }
        joints.push(("torso_t0", TORSO_T0_RAD, 0.0));
        joints.sort_by_key(|(name, _, _)| *name);
        JointStates::new(joints)
    }

    /// An electric gripper's one-joint message, which shares the topic with the 17.
    pub fn finger_joint_states(&self, side: Side) -> Option<JointStates> {
        let name = match side {
            Side::Left => "l_gripper_l_finger_joint",
            Side::Right => "r_gripper_l_finger_joint",
        };
        let gripper = self.hand(side).electric()?;
        Some(JointStates::new([(name, gripper.finger_position_m(), 0.0)]))
    }

    fn step_once(&mut self, dt_s: f64) {
        self.assembly.step(dt_s);
        let may_move = self.assembly.allows_motion();
        self.time_s += dt_s;
        for side in Side::BOTH {
            let takes_commands = may_move && !self.cuff_held(side);
            let reason = if !may_move {
                Some("the robot is stopped or not enabled")
            } else if self.cuff_held(side) {
                Some("the cuff is held")
            } else if !self.collision_objects(side).is_empty() || self.impact(side) {
                Some("a collision is reported")
            } else {
                None
            };
            self.contracts[side as usize].forbid(reason, takes_commands, self.time_s);
        }
        for (arm, cuff_held) in self.arms.iter_mut().zip(self.cuffs_held) {
            if !may_move || cuff_held {
                arm.hold();
            }
            arm.step(dt_s);
        }
        if !may_move {
            self.head_goal = Goal::Hold;
        }
        self.head.step(self.head_goal, dt_s);
        for hand in &mut self.hands {
            hand.step(dt_s, may_move);
        }
    }
}
