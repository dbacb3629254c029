//! Names the object of each scan after each of its views, and of any cloud on request.

mod models;

use anyhow::Context;
use classifier::{Answer, Model, Parameters};
use models::Models;
use msg::deformable_cobot::{
    Classification, ClassifyCloud, ClassifyCloudReq, ClassifyCloudRes, LoadModel, LoadModelRes,
    ObjectCloud,
};
use msg::progress::Progress;
use msg::sensor_msgs::PointCloud2;
use msg::timing;
use nalgebra::Vector3;
use node::{Expect, Latch, Level, Node};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

fn main() -> ExitCode {
    node::run("classifier", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let models = Models::load(&parameters)
        .with_context(|| format!("cannot use the model '{}'", parameters.model))?;
    let models = Arc::new(models);
    tell(&node, &models);
    let answers = node.publish("classification", 16, Latch::Yes)?;
    let progress = Mutex::new(Progress::default());
    let _objects = node.subscribe("object", Expect::EVENTS, {
        let models = Arc::clone(&models);
        move |object: ObjectCloud| {
            let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
            if progress.advance(&object.scan_id, object.view_count, object.complete) {
                let model = models.of_scan(&object.scan_id);
                answers.send(name_object(&model, object));
            }
        }
    })?;
    let _classify = node.serve::<ClassifyCloud>("classify_cloud", {
        let models = Arc::clone(&models);
        move |request, _| {
            let model = models.in_force();
            async move {
                let result = node::compute(move || classify_at_once(&model, &request)).await?;
                Ok(ClassifyCloudRes { result })
            }
        }
    })?;
    let _load = node.serve::<LoadModel>("load_model", {
        let node = node.clone();
        move |request, _| {
            let (node, models) = (node.clone(), Arc::clone(&models));
            let parameters = Parameters {
                model: request.model,
                ..parameters.clone()
            };
            node::compute(move || exchange(&node, &models, &parameters))
        }
    })?;
    node.until_shutdown().await;
    Ok(())
}

/// Exchanges the model; the answer is of the one in force afterwards.
fn exchange(node: &Node, models: &Models, parameters: &Parameters) -> LoadModelRes {
    let error = match models.exchange(parameters) {
        Ok(()) => {
            // A classifier that is started again takes the new one.
            node.change_parameters(parameters);
            tell(node, models);
            String::new()
        }
        Err(error) => {
            let error = format!("{:#}", anyhow::Error::from(error));
            log::error!("load_model: {error}; the model of before stays in force");
            error
        }
    };
    let model = models.in_force();
    let model = model.lock().unwrap_or_else(PoisonError::into_inner);
    LoadModelRes {
        error,
        model_id: model.metadata().run_id.clone(),
        labels: model.metadata().labels.clone(),
    }
}

/// Says in log and diagnostics which model is in force, and what runs it.
fn tell(node: &Node, models: &Models) {
    let model = models.in_force();
    let model = model.lock().unwrap_or_else(PoisonError::into_inner);
    match model.fallback_reason() {
        None => node.health().set("provider", Level::Ok, model.provider()),
        Some(reason) => {
            let text = format!(
                "running on {} instead of what was asked for: {reason}",
                model.provider()
            );
            log::error!("{text}");
            node.health().set("provider", Level::Warn, text);
        }
    }
    let metadata = model.metadata();
    log::info!(
        "model {} knows {} on {}",
        metadata.run_id,
        metadata.labels.join(", "),
        model.provider()
    );
}

/// The answer to a cloud from anywhere.
fn classify_at_once(model: &Mutex<Model>, request: &ClassifyCloudReq) -> Classification {
    let up = up_or_z([request.up.x, request.up.y, request.up.z]);
    let mut result = Classification {
        header: request.cloud.header.clone(),
        complete: true,
        ..Default::default()
    };
    answer_into(model, &request.cloud, up, &mut result);
    result
}

/// The answer to a scan so far; what went wrong before comes through as it is.
fn name_object(model: &Mutex<Model>, object: ObjectCloud) -> Classification {
    let mut result = Classification {
        header: object.header,
        scan_id: object.scan_id,
        error: object.error,
        view_count: object.view_count,
        complete: object.complete,
        registered_count: object.registered_count,
        refused_count: object.refused_count,
        timing: object.timing,
        ..Default::default()
    };
    if result.error.is_empty() {
        let up = up_or_z([object.up.x, object.up.y, object.up.z]);
        if object.empty {
            nothing_into(model, &object.cloud, &mut result);
        } else {
            answer_into(model, &object.cloud, up, &mut result);
            doubt_into(object.doubt, &mut result);
        }
    }
    report(&result);
    result
}

/// The log keeps to the answer that ends a scan; a sweep has one after each view.
fn report(result: &Classification) {
    let (scan_id, views) = (&result.scan_id, result.view_count);
    let probability = result.probability;
    let said = match (&result.error[..], &result.label[..]) {
        ("", "") => "the hand is empty".to_owned(),
        ("", label) if result.known => format!("{label} ({probability:.3})"),
        ("", label) => format!(
            "unknown, most like {label} ({probability:.3}): {}",
            result.reason
        ),
        (error, _) => {
            log::error!("scan {scan_id}: {error}");
            return;
        }
    };
    let level = if result.complete {
        log::Level::Info
    } else {
        log::Level::Debug
    };
    log::log!(level, "scan {scan_id}: {said}, by {views} view(s)");
}

/// An empty hand has no label, and nothing is known of it.
fn nothing_into(model: &Mutex<Model>, cloud: &PointCloud2, result: &mut Classification) {
    let model = model.lock().unwrap_or_else(PoisonError::into_inner);
    result.point_count = cloud.width * cloud.height;
    result.reason = "the hand holds nothing".to_owned();
    result.known_threshold = model.metadata().known_threshold;
    result.provider = model.provider().into();
    result.model_id.clone_from(&model.metadata().run_id);
}

fn answer_into(
    model: &Mutex<Model>,
    cloud: &PointCloud2,
    up: Vector3<f64>,
    result: &mut Classification,
) {
    let mut model = model.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = msg::cloud::to_points(cloud)
        .map_err(anyhow::Error::from)
        .and_then(|decoded| {
            result.point_count = decoded.points.len() as u32;
            Ok(model.classify(&decoded.points, &up)?)
        });
    result.provider = model.provider().into();
    result.model_id.clone_from(&model.metadata().run_id);
    match answer {
        Ok(answer) => fill(result, answer),
        Err(error) => result.error = format!("classifier: {error:#}"),
    }
}

/// What is made of a scan that is not to be trusted is not known, whatever the model says.
fn doubt_into(doubt: String, result: &mut Classification) {
    if !doubt.is_empty() && result.error.is_empty() {
        result.known = false;
        result.reason = doubt;
    }
}

fn fill(result: &mut Classification, answer: Answer) {
    result.reason = answer.doubt().unwrap_or_default();
    result.known_score = answer.known_score;
    result.known_threshold = answer.known_threshold;
    result.label = answer.label;
    result.probability = answer.probability;
    result.known = answer.known;
    result.labels = answer.labels;
    result.probabilities = answer.probabilities;
    result
        .timing
        .push(timing::stage("sample", answer.timing.sample));
    result
        .timing
        .push(timing::stage("infer", answer.timing.infer));
}

/// A message without an up direction means +z.
fn up_or_z(up: [f64; 3]) -> Vector3<f64> {
    let up = Vector3::from(up);
    if up == Vector3::zeros() {
        Vector3::z()
    } else {
        up
    }
}
