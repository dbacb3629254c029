//! What the simulated robot subscribes to.

use std::fmt::Display;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use baxter::{Side, W2};
use msg::baxter_core_msgs::{EndEffectorCommand, HeadPanCommand, JointCommand};
use msg::reflex_msgs::PoseCommand;
use msg::std_msgs;
use node::{Expect, Node, Subscriber};
use sim_baxter::{GripperCommand, Hand, Robot};

use crate::Simulation;

/// Clients repeat their commands at 100 Hz; complaints about them need not.
const COMPLAINT_PERIOD: Duration = Duration::from_secs(5);

/// Subscribes to everything; the robot hears nothing once the result is dropped.
pub fn listen(node: &Node, simulation: &Simulation) -> anyhow::Result<Vec<Subscriber>> {
    let mut subscribers = listen_to_buttons(node, simulation)?;
    for side in Side::BOTH {
        subscribers.extend(listen_to_arm(node, simulation, side)?);
        subscribers.extend(listen_to_hand(node, simulation, side)?);
    }
    subscribers.push(listen_to_head(node, simulation)?);
    subscribers.extend(listen_to_mishaps(node, simulation)?);
    Ok(subscribers)
}

fn listen_to_buttons(node: &Node, simulation: &Simulation) -> anyhow::Result<Vec<Subscriber>> {
    Ok(vec![
        on(
            node,
            simulation,
            "/robot/set_super_enable",
            |robot, enable: std_msgs::Bool| {
                robot.assembly.enable(enable.data);
            },
        )?,
        on(
            node,
            simulation,
            "/robot/set_super_reset",
            |robot, _: std_msgs::Empty| {
                robot.assembly.reset();
            },
        )?,
        on(
            node,
            simulation,
            "/robot/set_super_stop",
            |robot, _: std_msgs::Empty| {
                robot.assembly.stop();
            },
        )?,
    ])
}

fn listen_to_arm(
    node: &Node,
    simulation: &Simulation,
    side: Side,
) -> anyhow::Result<Vec<Subscriber>> {
    let topic = |name: &str| format!("{}/{name}", side.limb_topics());
    let complaints = Complaints::default();
    let command = move |robot: &mut Robot, command: JointCommand| {
        let result = robot.command_arm(side, command.mode, &command.names, &command.command);
        complaints.take(result);
    };
    Ok(vec![
        on(node, simulation, &topic("joint_command"), command)?,
        on(
            node,
            simulation,
            &topic("set_speed_ratio"),
            move |robot, ratio: std_msgs::Float64| {
                robot.arm_mut(side).set_speed_ratio(ratio.data);
            },
        )?,
        on(
            node,
            simulation,
            &topic("joint_command_timeout"),
            move |robot, timeout: std_msgs::Float64| {
                robot.arm_mut(side).set_command_timeout(timeout.data);
            },
        )?,
    ])
}

/// The hand's driver, of whichever kind it is.
fn listen_to_hand(
    node: &Node,
    simulation: &Simulation,
    side: Side,
) -> anyhow::Result<Option<Subscriber>> {
    let hand = simulation.now().hand(side).clone();
    Ok(match hand {
        Hand::None => None,
        Hand::Electric(_) => Some(on(
            node,
            simulation,
            &format!("{}/command", side.gripper_topics()),
            grip(side),
        )?),
        Hand::Reflex(_) => Some(on(
            node,
            simulation,
            &format!("{}/command_position", side.reflex_topics()),
            move |robot, pose: PoseCommand| {
                if let Some(hand) = robot.hand_mut(side).reflex_mut() {
                    hand.command([pose.f1, pose.f2, pose.f3, pose.preshape]);
                }
            },
        )?),
    })
}

fn grip(side: Side) -> impl Fn(&mut Robot, EndEffectorCommand) {
    let complaints = Complaints::default();
    move |robot, command| {
        let EndEffectorCommand {
            id,
            command,
            args,
            sender,
            sequence,
        } = command;
        let command = GripperCommand {
            id,
            command,
            args,
            sender,
            sequence,
        };
        if let Some(gripper) = robot.hand_mut(side).electric_mut() {
            complaints.take(gripper.command(&command));
        }
    }
}

fn listen_to_head(node: &Node, simulation: &Simulation) -> anyhow::Result<Subscriber> {
    let turn = |robot: &mut Robot, command: HeadPanCommand| {
        if command.enable_pan_request != HeadPanCommand::REQUEST_PAN_DISABLE {
            robot.command_head(f64::from(command.target), f64::from(command.speed_ratio));
        }
    };
    on(node, simulation, "/robot/head/command_head_pan", turn)
}

/// Private topics that a real robot has no counterpart for: what people and things do to it.
fn listen_to_mishaps(node: &Node, simulation: &Simulation) -> anyhow::Result<Vec<Subscriber>> {
    let clock = simulation.clone();
    let publishing = simulation.clone();
    let silence = move |what: std_msgs::String| publishing.silence(what.data);
    let step_clock = move |offset_s: std_msgs::Float64| clock.step_clock(offset_s.data);
    Ok(vec![
        node.subscribe("~step_clock", Expect::COMMANDS, step_clock)?,
        node.subscribe("~silence", Expect::COMMANDS, silence)?,
        on(
            node,
            simulation,
            "~jam_left_wrist",
            |robot, jammed: std_msgs::Bool| {
                robot.arm_mut(Side::Left).jam(W2, jammed.data);
            },
        )?,
        on(
            node,
            simulation,
            "~left_impact",
            |robot, impact: std_msgs::Bool| {
                robot.set_impact(Side::Left, impact.data);
            },
        )?,
        on(
            node,
            simulation,
            "~press_estop",
            |robot, press: std_msgs::Bool| {
                if press.data {
                    robot.assembly.press_estop()
                } else {
                    robot.assembly.release_estop()
                }
            },
        )?,
        on(
            node,
            simulation,
            "~report_error",
            |robot, error: std_msgs::Bool| {
                robot.assembly.set_error(error.data);
            },
        )?,
        on(
            node,
            simulation,
            "~hold_left_cuff",
            |robot, held: std_msgs::Bool| {
                robot.hold_cuff(Side::Left, held.data);
            },
        )?,
        on(
            node,
            simulation,
            "~hold_right_cuff",
            |robot, held: std_msgs::Bool| {
                robot.hold_cuff(Side::Right, held.data);
            },
        )?,
        on(
            node,
            simulation,
            "~left_collision_object",
            |robot, object: std_msgs::String| {
                let objects = Some(object.data).filter(|name| !name.is_empty());
                robot.set_collision_objects(Side::Left, objects.into_iter().collect());
            },
        )?,
        on(node, simulation, "~left_object_width_m", hold(Side::Left))?,
        on(node, simulation, "~right_object_width_m", hold(Side::Right))?,
    ])
}

fn hold(side: Side) -> impl Fn(&mut Robot, std_msgs::Float64) {
    move |robot, width| {
        let width_m = Some(width.data).filter(|width_m| *width_m > 0.0);
        robot.hand_mut(side).hold(width_m);
    }
}

/// Subscribes to `topic` with what the robot does about it.
fn on<T: msg::Message>(
    node: &Node,
    simulation: &Simulation,
    topic: &str,
    act: impl Fn(&mut Robot, T) + Send + Sync + 'static,
) -> anyhow::Result<Subscriber> {
    let simulation = simulation.clone();
    node.subscribe(topic, Expect::COMMANDS, move |message: T| {
        act(&mut simulation.now(), message)
    })
}

/// Logs why commands are not obeyed: each new reason, and the same one again now and then.
#[derive(Default)]
struct Complaints {
    last: Mutex<Option<(String, Instant)>>,
}

impl Complaints {
    fn take<E: Display>(&self, result: Result<(), E>) {
        let Err(error) = result else { return };
        let text = error.to_string();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last
            .as_ref()
            .is_some_and(|(known, since)| *known == text && since.elapsed() < COMPLAINT_PERIOD);
        if !known {
            log::warn!("{text}");
            *last = Some((text, Instant::now()));
        }
    }
}
