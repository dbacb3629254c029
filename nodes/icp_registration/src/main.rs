//! Registers the views of each scan as they come, and any views on request.

mod progress;
mod scan;

use std::process::ExitCode;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use icp_registration::{InitialGuess, Parameters};
use msg::deformable_cobot::{
    RegisterViews, RegisterViewsReq, RegisterViewsRes, RegisteredCloud, View,
};
use node::{Expect, Latch, Node};
use progress::Progress;
use scan::Scan;

fn main() -> ExitCode {
    node::run("icp_registration", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let progress = Arc::new(Mutex::new(Progress::new(parameters.clone())));
    let tuned = node.tune(parameters, Parameters::TUNABLES, Parameters::validate)?;
    let registered = node.publish("registered", 16, Latch::Yes)?;
    let clouds = node.publish("registered/cloud", 4, Latch::Yes)?;
    let _views = node.subscribe("views", Expect::EVENTS, {
        let (progress, tuned) = (Arc::clone(&progress), tuned.clone());
        move |view: View| {
            let mut progress = lock(&progress);
            progress.set_parameters(&tuned.now());
            let Some(message) = progress.on_view(view) else {
                return;
            };
            let cloud = message.error.is_empty().then(|| message.cloud.clone());
            if !message.error.is_empty() {
                log::error!("scan {}: {}", message.scan_id, message.error);
            }
            // The later stages first, then those who look on.
            registered.send(message);
            if let Some(cloud) = cloud {
                clouds.send(cloud);
            }
            progress.prepare();
        }
    })?;
    node.clock().on_jump(move || lock(&progress).abandon());
    let _service = node.serve::<RegisterViews>("register_views", move |request, _| {
        let parameters = tuned.now();
        async move {
            let register = move || register_at_once(&parameters, request);
            let registered = node::compute(register).await?;
            Ok(RegisterViewsRes { registered })
        }
    })?;
    node.until_shutdown().await;
    Ok(())
}

/// The views of a request, in its order, whatever scans they come from.
fn register_at_once(parameters: &Parameters, request: RegisterViewsReq) -> RegisteredCloud {
    let initial_guess = match &request.initial_guess[..] {
        "" => parameters.initial_guess,
        "kinematic" => InitialGuess::Kinematic,
        "identity" => InitialGuess::Identity,
        other => {
            return failed(format!(
                "initial_guess is {other:?}; it must be kinematic, identity or empty"
            ));
        }
    };
    let Some(first) = request.views.first() else {
        return failed("the request has no views".to_owned());
    };
    let (scan_id, count) = (first.scan_id.clone(), request.views.len() as u32);
    let parameters = Parameters {
        initial_guess,
        ..parameters.clone()
    };
    let mut scan = match Scan::new(parameters, scan_id, count) {
        Ok(scan) => scan,
        Err(error) => return failed(error.to_string()),
    };
    request.views.iter().for_each(|view| scan.add(view));
    scan.message()
}

fn failed(error: String) -> RegisteredCloud {
    RegisteredCloud {
        error: format!("icp_registration: {error}"),
        ..Default::default()
    }
}

fn lock(progress: &Mutex<Progress>) -> MutexGuard<'_, Progress> {
    progress.lock().unwrap_or_else(PoisonError::into_inner)
}
