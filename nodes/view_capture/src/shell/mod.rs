//! The node: topics and services around the rules in the library.

mod active;
mod answers;
mod output;
mod passive;
mod troubles;

use active::Scanner;
use msg::deformable_cobot::{Classification, ScanObject, ScanObjectRes};
use msg::sensor_msgs::PointCloud2;
use node::{Expect, Node, Transforms};
use output::Output;
use std::sync::Arc;
use tokio::sync::{broadcast, watch};
use troubles::Troubles;
use view_capture::{Mode, Parameters};

/// Answers kept for a scan that looks for its own.
const ANSWERS_KEPT: usize = 64;

/// Sets the node up and serves until shutdown.
pub async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters = Arc::new(node.parameters(Parameters::validate)?);
    let transforms = parameters.use_tf.then(|| node.transforms()).transpose()?;
    let output = Output::new(&node)?;
    match parameters.mode {
        Mode::Active => serve_active(node, parameters, transforms, output).await,
        Mode::Passive => serve_passive(node, parameters, transforms, output).await,
    }
}

async fn serve_active(
    node: Node,
    parameters: Arc<Parameters>,
    transforms: Option<Transforms>,
    output: Output,
) -> anyhow::Result<()> {
    let clouds = watch::Sender::new(None);
    let answers = broadcast::Sender::new(ANSWERS_KEPT);
    let troubles = Troubles::listen(&node)?;
    let scanner = Scanner::new(
        &node, parameters, transforms, output, troubles, &clouds, &answers,
    );
    let _points = node.subscribe("points", Expect::STATE, move |cloud: PointCloud2| {
        clouds.send_replace(Some(Arc::new(cloud)));
    })?;
    let _answers = node.subscribe(
        "classification",
        Expect::EVENTS,
        move |answer: Classification| {
            // Nobody waits for an answer between scans.
            let _ = answers.send(answer);
        },
    )?;
    let runtime = tokio::runtime::Handle::current();
    let _service = node.serve_caller::<ScanObject>("scan_object", {
        let scanner = scanner.clone();
        move |request, caller| Ok(runtime.block_on(scanner.scan(request.views, caller.gone())))
    })?;
    let at_start = scanner.scan_at_start();
    tokio::select! {
        () = node.until_shutdown() => {}
        () = at_start => {}
    }
    Ok(())
}

async fn serve_passive(
    node: Node,
    parameters: Arc<Parameters>,
    transforms: Option<Transforms>,
    output: Output,
) -> anyhow::Result<()> {
    let _service = node.serve::<ScanObject>("scan_object", |_| {
        let error = "view_capture watches in passive mode; whoever turns the wrist makes the scan. \
                     Set ~mode to active to scan on request";
        Ok(ScanObjectRes {
            error: error.into(),
            ..Default::default()
        })
    })?;
    passive::watch(&node, parameters, transforms, output).await
}
