//! The node: topics and services around the rules in the library.

mod arm_pose;
mod capture;
mod clouds;
mod computers;
mod passive;
mod requests;
mod sweep;
mod time_offset;
mod view;
mod watched;
mod wrist;

use arm_pose::ArmPose;
use capture::{Capture, Sources};
use clouds::Clouds;
use computers::OtherComputers;
use msg::deformable_cobot::{CaptureViews, CaptureViewsRes, PlanViews, PlanViewsRes};
use node::{Latch, Node, Transforms, Tuned};
use std::sync::Arc;
use time_offset::TimeOffset;
use view_capture::{Mode, Parameters};
use wrist::Wrist;

/// Sets the node up and serves until shutdown.
pub async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let mode = parameters.mode;
    let transforms = parameters.use_tf.then(|| node.transforms()).transpose()?;
    let parameters = node.tune(parameters, Parameters::TUNABLES, Parameters::validate)?;
    match mode {
        Mode::Active => serve_active(node, parameters, transforms).await,
        Mode::Passive => serve_passive(node, parameters, transforms).await,
    }
}

async fn serve_active(
    node: Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
) -> anyhow::Result<()> {
    let arm_pose = transforms
        .clone()
        .map(|transforms| ArmPose::listen(&node, transforms))
        .transpose()?;
    let clouds = Clouds::new();
    let wrist = Wrist::new(parameters.now().side.wrist_joint());
    let (offset, _registered) = TimeOffset::learn(&node, &parameters)?;
    let computers = OtherComputers::watch(&node, &parameters, wrist.listener())?;
    let sources = Sources {
        transforms,
        arm_pose,
        clouds: clouds.clone(),
        computers: computers.clone(),
        stops: node.follow_count("wrist_stops")?,
        wrist,
        offset,
    };
    let captured = node.publish("captured", 16, Latch::No)?;
    let capture = Arc::new(Capture::new(&node, parameters, sources, captured));
    let _plan = node.serve::<PlanViews>("plan_views", {
        let capture = Arc::clone(&capture);
        move |request, _| std::future::ready(Ok(capture.plan(request)))
    })?;
    let _capture = node.serve::<CaptureViews>("capture_views", move |request, life| {
        let capture = Arc::clone(&capture);
        async move { Ok(capture.capture(request, life).await) }
    })?;
    tokio::select! {
        () = node.until_shutdown() => Ok(()),
        failed = clouds.serve(&node, &computers) => match failed? {},
        never = computers.report() => match never {},
    }
}

async fn serve_passive(
    node: Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
) -> anyhow::Result<()> {
    let refusal = "view_capture watches in passive mode; whoever turns the wrist makes the scan. Set its ~mode to active \
                   to scan on request";
    let _plan = node.serve::<PlanViews>("plan_views", move |_, _| {
        std::future::ready(Ok(PlanViewsRes {
            error: refusal.into(),
            ..Default::default()
        }))
    })?;
    let _capture = node.serve::<CaptureViews>("capture_views", move |_, _| {
        std::future::ready(Ok(CaptureViewsRes {
            error: refusal.into(),
            ..Default::default()
        }))
    })?;
    passive::watch(&node, parameters, transforms).await
}
