//! The gripper as a ROS node: service `grasp`.

mod shell;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use gripper::{
    Electric, ElectricState, FINGERS, FingerState, Hand, HandKind, Parameters, Reflex, Task,
};
use msg::baxter_core_msgs::{AssemblyState, EndEffectorCommand, EndEffectorState};
use msg::deformable_cobot::{Grasp, GraspReq, GraspRes};
use msg::reflex_msgs;
use node::{Expect, Life, Node};
use shell::{Ending, Shell};

fn main() -> ExitCode {
    node::run("gripper", run)
}

async fn run(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    match parameters.hand {
        HandKind::Electric => run_electric(node, &parameters).await,
        HandKind::Reflex => run_reflex(node, &parameters).await,
    }
}

async fn run_electric(node: Node, parameters: &Parameters) -> anyhow::Result<()> {
    let base = parameters.electric_base();
    let commands = node.publish_prompt(&format!("{base}/command"), 10)?;
    let hand = Electric::new(parameters, &node.name());
    let shell = Shell::new(hand, parameters, commands, electric_command);
    let _states = node.subscribe(&format!("{base}/state"), Expect::STATE, {
        let shell = Arc::clone(&shell);
        move |state: EndEffectorState| shell.hand().hear(electric_state(state), Instant::now())
    })?;
    serve(&node, shell, &base).await
}

async fn run_reflex(node: Node, parameters: &Parameters) -> anyhow::Result<()> {
    let base = parameters.reflex_base();
    let commands = node.publish_prompt(&format!("{base}/command_position"), 10)?;
    let shell = Shell::new(Reflex::new(parameters), parameters, commands, pose_command);
    let _states = node.subscribe(&format!("{base}/hand_state"), Expect::STATE, {
        let shell = Arc::clone(&shell);
        move |hand: reflex_msgs::Hand| shell.hand().hear(finger_states(&hand), Instant::now())
    })?;
    serve(&node, shell, &base).await
}

/// Offers the service until shutdown.
async fn serve<H, M>(node: &Node, shell: Arc<Shell<H, M>>, hardware_id: &str) -> anyhow::Result<()>
where
    H: Hand + Send + 'static,
    M: msg::Message,
{
    let _robot = node.subscribe("/robot/state", Expect::STATE, {
        let shell = Arc::clone(&shell);
        move |state: AssemblyState| shell.hear_robot(msg::robot::state(&state))
    })?;
    let _service = node.serve::<Grasp>("grasp", {
        let shell = Arc::clone(&shell);
        move |request, life| {
            let shell = Arc::clone(&shell);
            async move { Ok(grasp(&shell, request, &life).await) }
        }
    })?;
    let health = node.health();
    health.set_hardware(hardware_id);
    tokio::select! {
        () = shell.report_health(&health) => {}
        () = node.until_shutdown() => {}
    }
    shell.stop().await;
    Ok(())
}

async fn grasp<H: Hand, M: msg::Message>(
    shell: &Shell<H, M>,
    request: GraspReq,
    life: &Life,
) -> GraspRes {
    let ending = match Task::new(&request.command, request.width, request.force) {
        Ok(task) => shell.grasp(task, life).await,
        Err(refusal) => Ending::Refused(refusal),
    };
    let (outcome, error) = match ending {
        Ending::Well(grasped) => {
            let outcome = match grasped.outcome {
                gripper::Outcome::Gripped => GraspRes::GRIPPED,
                gripper::Outcome::Missed => GraspRes::MISSED,
                gripper::Outcome::Reached => GraspRes::REACHED,
            };
            (outcome, String::new())
        }
        Ending::Refused(error) => (GraspRes::REFUSED, error.to_string()),
        Ending::Failed(error) => (GraspRes::FAILED, error.to_string()),
    };
    let width = shell.hand().width_m().unwrap_or(f64::NAN);
    match &error[..] {
        "" => log::info!("grasp {}: {outcome}, {width:.4} m", request.command),
        error => log::warn!("grasp {}: {outcome}: {error}", request.command),
    }
    GraspRes {
        outcome: outcome.into(),
        error,
        width,
    }
}

fn electric_command(command: gripper::ElectricCommand) -> EndEffectorCommand {
    EndEffectorCommand {
        id: command.id,
        command: command.command.into(),
        args: command.args,
        sender: command.sender,
        sequence: command.sequence,
    }
}

fn electric_state(state: EndEffectorState) -> ElectricState {
    ElectricState {
        id: state.id,
        enabled: state.enabled.into(),
        calibrated: state.calibrated.into(),
        ready: state.ready.into(),
        moving: state.moving.into(),
        gripping: state.gripping.into(),
        missed: state.missed.into(),
        error: state.error.into(),
        position: f64::from(state.position),
        sender: state.command_sender,
        sequence: state.command_sequence,
    }
}

fn pose_command(pose: gripper::PoseCommand) -> reflex_msgs::PoseCommand {
    let [f1, f2, f3] = pose.fingers_rad;
    reflex_msgs::PoseCommand {
        f1,
        f2,
        f3,
        preshape: pose.preshape_rad,
    }
}

fn finger_states(hand: &reflex_msgs::Hand) -> [FingerState; FINGERS] {
    std::array::from_fn(|index| FingerState {
        angle_rad: hand.motor[index].joint_angle,
        load: hand.motor[index].load,
    })
}
