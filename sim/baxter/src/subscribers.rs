//! What the simulated robot subscribes to.

use std::fmt::Display;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use baxter::{Side, W2};
use msg::baxter_core_msgs::{EndEffectorCommand, HeadPanCommand, JointCommand};
use msg::reflex_msgs::PoseCommand;
use msg::std_msgs::{self, Bool, Empty, Float64};
use node::{Expect, Node, Subscriber};
use sim_baxter::{GripperCommand, Hand, Robot};

use crate::Simulation;

/// Clients repeat their commands at 100 Hz; complaints about them need not.
const COMPLAINT_PERIOD: Duration = Duration::from_secs(5);

/// Subscribes to everything; the robot hears nothing once the result is dropped.
pub fn listen(node: &Node, simulation: &Simulation) -> anyhow::Result<Vec<Subscriber>> {
    let mut topics = Topics {
        node,
        simulation,
        subscribers: Vec::new(),
    };
    topics.buttons()?;
    for side in Side::BOTH {
        topics.arm(side)?;
        topics.hand(side)?;
    }
    topics.head()?;
    topics.mishaps()?;
    Ok(topics.subscribers)
}

struct Topics<'a> {
    node: &'a Node,
    simulation: &'a Simulation,
    subscribers: Vec<Subscriber>,
}

impl Topics<'_> {
    /// Subscribes to `topic` with what the robot does about a message.
    fn on<T: msg::Message>(
        &mut self,
        topic: &str,
        act: impl Fn(&mut Robot, T) + Send + Sync + 'static,
    ) -> anyhow::Result<()> {
        let simulation = self.simulation.clone();
        let act = move |message: T| act(&mut simulation.now(), message);
        let subscriber = self.node.subscribe(topic, Expect::COMMANDS, act)?;
        self.subscribers.push(subscriber);
        Ok(())
    }

    fn buttons(&mut self) -> anyhow::Result<()> {
        self.on("/robot/set_super_enable", |robot, Bool { data }| {
            robot.assembly.enable(data);
        })?;
        self.on("/robot/set_super_reset", |robot, _: Empty| {
            robot.assembly.reset();
        })?;
        self.on("/robot/set_super_stop", |robot, _: Empty| {
            robot.assembly.stop();
        })
    }

    fn arm(&mut self, side: Side) -> anyhow::Result<()> {
        let topic = |name: &str| format!("{}/{name}", side.limb_topics());
        let complaints = Complaints::default();
        let command = move |robot: &mut Robot, command: JointCommand| {
            let result = robot.command_arm(side, command.mode, &command.names, &command.command);
            complaints.take(result);
        };
        self.on(&topic("joint_command"), command)?;
        let set_ratio = move |robot: &mut Robot, Float64 { data }| {
            robot.arm_mut(side).set_speed_ratio(data);
        };
        self.on(&topic("set_speed_ratio"), set_ratio)?;
        let set_timeout = move |robot: &mut Robot, Float64 { data }| {
            robot.arm_mut(side).set_command_timeout(data);
        };
        self.on(&topic("joint_command_timeout"), set_timeout)
    }

    /// The hand's driver, of whichever kind it is.
    fn hand(&mut self, side: Side) -> anyhow::Result<()> {
        let hand = self.simulation.now().hand(side).clone();
        match hand {
            Hand::None => Ok(()),
            Hand::Electric(_) => {
                let topic = format!("{}/command", side.gripper_topics());
                self.on(&topic, grip(side))
            }
            Hand::Reflex(_) => {
                let topic = format!("{}/command_position", side.reflex_topics());
                self.on(&topic, move |robot, pose: PoseCommand| {
                    if let Some(hand) = robot.hand_mut(side).reflex_mut() {
                        hand.command([pose.f1, pose.f2, pose.f3, pose.preshape]);
                    }
                })
            }
        }
    }

    fn head(&mut self) -> anyhow::Result<()> {
        let turn = |robot: &mut Robot, command: HeadPanCommand| {
            if command.enable_pan_request != HeadPanCommand::REQUEST_PAN_DISABLE {
                robot.command_head(f64::from(command.target), f64::from(command.speed_ratio));
            }
        };
        self.on("/robot/head/command_head_pan", turn)
    }

    /// Private topics that exist only in simulation. They stand for what people and obstacles do to the robot: emergency stop, cuff,
    /// collision.
    fn mishaps(&mut self) -> anyhow::Result<()> {
        let (clock, publishing) = (self.simulation.clone(), self.simulation.clone());
        let silence = move |what: std_msgs::String| publishing.silence(what.data);
        let step_clock = move |offset_s: Float64| clock.step_clock(offset_s.data);
        let (node, commands) = (self.node, Expect::COMMANDS);
        self.subscribers.extend([
            node.subscribe("~step_clock", commands, step_clock)?,
            node.subscribe("~silence", commands, silence)?,
        ]);
        self.on("~jam_left_wrist", |robot, Bool { data }| {
            robot.arm_mut(Side::Left).jam(W2, data);
        })?;
        self.on("~left_impact", |robot, Bool { data }| {
            robot.set_impact(Side::Left, data);
        })?;
        self.on("~press_estop", |robot, Bool { data }| {
            if data {
                robot.assembly.press_estop()
            } else {
                robot.assembly.release_estop()
            }
        })?;
        self.on("~report_error", |robot, Bool { data }| {
            robot.assembly.set_error(data);
        })?;
        self.on(
            "~left_collision_object",
            |robot, object: std_msgs::String| {
                let objects = Some(object.data).filter(|name| !name.is_empty());
                robot.set_collision_objects(Side::Left, objects.into_iter().collect());
            },
        )?;
        for side in Side::BOTH {
            let name = side.name();
            let hold_cuff = move |robot: &mut Robot, Bool { data }| robot.hold_cuff(side, data);
            self.on(&format!("~hold_{name}_cuff"), hold_cuff)?;
            self.on(&format!("~{name}_object_width_m"), hold(side))?;
        }
        Ok(())
    }
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

fn hold(side: Side) -> impl Fn(&mut Robot, Float64) {
    move |robot, width| {
        let width_m = Some(width.data).filter(|width_m| *width_m > 0.0);
        robot.hand_mut(side).hold(width_m);
    }
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
