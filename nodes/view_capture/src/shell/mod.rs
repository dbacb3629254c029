//! The node: topics and services around the rules in the library.

mod action;
mod active;
mod answers;
mod output;
mod passive;
mod progress;
mod stance;
mod surroundings;
mod troubles;
mod wrist;

use action::Action;
use active::{Scanned, Scanner, Sources};
use msg::deformable_cobot::{Classification, ScanObject, ScanObjectRes};
use msg::sensor_msgs::{JointState, PointCloud2};
use node::{Expect, Life, Node, Transforms, Tuned};
use output::{Output, Shot};
use progress::Progress;
use stance::Stance;
use std::sync::Arc;
use surroundings::Surroundings;
use tokio::sync::{broadcast, watch};
use view_capture::{Mode, Outcome, Parameters};

/// Answers kept for a scan that looks for its own.
const ANSWERS_KEPT: usize = 64;

/// Sets the node up and serves until shutdown.
pub async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let mode = parameters.mode;
    let transforms = parameters.use_tf.then(|| node.transforms()).transpose()?;
    let output = Output::new(&node)?;
    let parameters = node.tune(parameters, Parameters::TUNABLES, Parameters::validate)?;
    match mode {
        Mode::Active => serve_active(node, parameters, transforms, output).await,
        Mode::Passive => serve_passive(node, parameters, transforms, output).await,
    }
}

async fn serve_active(
    node: Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
    output: Output,
) -> anyhow::Result<()> {
    let shots = watch::Sender::new(None);
    let answers = broadcast::Sender::new(ANSWERS_KEPT);
    let progress = Progress::new();
    let action = Action::listen(&node)?;
    let surroundings = Surroundings::watch(&node, &parameters)?;
    let _joints = node.subscribe("/robot/joint_states", Expect::SHARED_STATE, {
        let (progress, joint) = (progress.clone(), parameters.now().side.wrist_joint());
        let surroundings = surroundings.clone();
        move |state: JointState| {
            surroundings.note_robot(state.header.stamp);
            if let Some(sample) = passive::sample_of(&state, joint) {
                progress.note_angle(sample.angle_rad);
            }
        }
    })?;
    let stance = transforms
        .clone()
        .map(|transforms| Stance::listen(&node, transforms))
        .transpose()?;
    let sources = Sources {
        transforms,
        stance,
        shots: shots.subscribe(),
        answers: answers.clone(),
        troubles: surroundings.listen()?,
        surroundings: surroundings.clone(),
    };
    let scanner = Scanner::new(&node, parameters, output, &progress, sources);
    let _points = node.subscribe("points", Expect::STATE, {
        let (surroundings, clock) = (surroundings.clone(), node.clock());
        move |cloud: PointCloud2| {
            surroundings.note_cloud(cloud.header.stamp);
            let arrived = clock.now();
            shots.send_replace(Some(Arc::new(Shot { cloud, arrived })));
        }
    })?;
    let _answers = node.subscribe("classification", Expect::EVENTS, {
        let progress = progress.clone();
        move |answer: Classification| {
            progress.note_answer(&answer);
            // Nobody waits for an answer between scans.
            let _ = answers.send(answer);
        }
    })?;
    let _service = node.serve::<ScanObject>("scan_object", {
        let scanner = scanner.clone();
        move |request, life| {
            let scanner = scanner.clone();
            async move { Ok(scanner.scan(request.views, &life).await.answer) }
        }
    })?;
    let on_goal = async |views, stop: action::Stop| {
        let life = Life::until(async move { stop.ordered().await.to_owned() });
        scanner.scan(views, &life).await
    };
    tokio::select! {
        () = node.until_shutdown() => {
            scanner.until_idle().await;
            Ok(())
        }
        never = progress.publish(&node) => match never? {},
        never = action.serve(Some(&progress), on_goal) => match never {},
        never = scanner.scan_at_start() => match never {},
        never = surroundings.report() => match never {},
    }
}

async fn serve_passive(
    node: Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
    output: Output,
) -> anyhow::Result<()> {
    let refusal = || {
        ScanObjectRes {
        error: "view_capture watches in passive mode; whoever turns the wrist makes the scan. Set ~mode to active to \
                scan on request"
            .into(),
        ..Default::default()
    }
    };
    let _service =
        node.serve::<ScanObject>("scan_object", move |_, _| std::future::ready(Ok(refusal())))?;
    let action = Action::listen(&node)?;
    let on_goal = async |_, _| Scanned {
        outcome: Outcome::Aborted,
        answer: refusal(),
    };
    tokio::select! {
        never = action.serve(None, on_goal) => match never {},
        watched = passive::watch(&node, parameters, transforms, output) => watched,
    }
}
