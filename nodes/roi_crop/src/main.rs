//! Cuts the object out of each registered cloud, and out of any on request.

mod display;

use display::Display;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::Context;
use msg::baxter_core_msgs::EndEffectorState;
use msg::deformable_cobot::{
    CropCloud, CropCloudRes, ObjectCloud, RegisteredCloud, ViewRegistration,
};
use msg::geometry_msgs::Point;
use msg::progress::Progress;
use msg::stamp::since_epoch;
use msg::timing;
use nalgebra::Point3;
use node::{Expect, Latch, Node, Subscriber};
use roi_crop::{Crop, CropError, Cropper, Frame, Openings, Parameters};

fn main() -> ExitCode {
    node::run("roi_crop", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters = node.parameters(Parameters::validate)?;
    let (fingers, _link) = Fingers::listen(&node, &parameters)?;
    let tuned = node.tune(parameters, Parameters::TUNABLES, Parameters::validate)?;
    let cropper = move || Cropper::new((*tuned.now()).clone());
    let objects = node.publish("object", 16, Latch::Yes)?;
    let clouds = node.publish("object/cloud", 4, Latch::Yes)?;
    let display = Display::new(&node)?;
    let progress = Mutex::new(Progress::default());
    let _registered = node.subscribe("registered", Expect::EVENTS, {
        let cropper = cropper.clone();
        move |registered: RegisteredCloud| {
            let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
            let (id, view_count) = (&registered.scan_id, registered.view_count);
            if !progress.advance(id, view_count, registered.complete) {
                return;
            }
            let cropper = match cropper() {
                Ok(cropper) => cropper,
                // They were checked when they were set.
                Err(error) => return log::error!("{error}"),
            };
            let shown = display.is_watched().then(|| registered.cloud.clone());
            let seen = since_epoch(registered.header.stamp);
            let opening_m = fingers.openings().at_m(seen);
            let object = cut_out(&cropper, registered, opening_m);
            if !object.error.is_empty() {
                log::error!("scan {}: {}", object.scan_id, object.error);
            }
            // The later stages first, then those who look on.
            objects.send(object.clone());
            if object.error.is_empty() {
                display.show(&cropper, shown.as_ref(), &object);
                clouds.send(object.cloud);
            }
        }
    })?;
    let _service = node.serve::<CropCloud>("crop_cloud", move |request, _| {
        let cropper = cropper();
        async move {
            let cropper = cropper.map_err(|error| error.to_string())?;
            // Nobody knows when that was, and how far apart the fingers were then.
            let cut = move || cut_out(&cropper, request.registered, None);
            let object = node::compute(cut).await?;
            Ok(CropCloudRes { object })
        }
    })?;
    node.until_shutdown().await;
    Ok(())
}

/// How far apart the fingers are when.
#[derive(Clone)]
struct Fingers(Arc<Mutex<Openings>>);

impl Fingers {
    /// Listens to the electric gripper. Where there is none, the opening stays unknown.
    fn listen(node: &Node, parameters: &Parameters) -> anyhow::Result<(Self, Subscriber)> {
        let (fingers, gap, clock) = (Self(Arc::default()), parameters.gap, node.clock());
        let topic = format!("{}/state", parameters.side.gripper_topics());
        let link = node.subscribe(&topic, Expect::OPTIONAL_STATE, {
            let fingers = fingers.clone();
            move |state: EndEffectorState| {
                // A gripper that does not stamp what it says means now.
                let said = Some(since_epoch(state.timestamp)).filter(|stamp| !stamp.is_zero());
                let width_m = gap.width_m(f64::from(state.position) / 100.0);
                fingers
                    .openings()
                    .hear(said.unwrap_or_else(|| since_epoch(clock.now())), width_m);
            }
        })?;
        Ok((fingers, link))
    }

    fn openings(&self) -> MutexGuard<'_, Openings> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The object of a registered cloud; what went wrong before comes through as it is.
fn cut_out(cropper: &Cropper, registered: RegisteredCloud, opening_m: Option<f64>) -> ObjectCloud {
    let mut object = ObjectCloud {
        header: registered.header.clone(),
        scan_id: registered.scan_id.clone(),
        error: registered.error.clone(),
        view_count: registered.view_count,
        complete: registered.complete,
        registered_count: registered.registered_count,
        refused_count: registered.refused_count,
        doubt: registered.doubt.clone(),
        in_hand_frame: registered.in_hand_frame,
        viewpoints: viewpoints(&registered),
        timing: registered.timing.clone(),
        ..Default::default()
    };
    if object.error.is_empty() {
        let (result, elapsed) = timing::timed("crop", || {
            crop(cropper, &registered, opening_m, &mut object)
        });
        object.timing.push(elapsed);
        if let Err(error) = result {
            object.error = format!("roi_crop: {error:#}");
        }
    }
    object
}

/// Where the camera was at each view that is in the cloud.
fn viewpoints(registered: &RegisteredCloud) -> Vec<Point> {
    let in_cloud = |view: &&ViewRegistration| view.accepted || registered.in_hand_frame;
    let views = registered.views.iter().filter(in_cloud);
    let place = |view: &ViewRegistration| {
        let camera = &view.transform.translation;
        Point {
            x: camera.x,
            y: camera.y,
            z: camera.z,
        }
    };
    views.map(place).collect()
}

fn crop(
    cropper: &Cropper,
    registered: &RegisteredCloud,
    opening_m: Option<f64>,
    object: &mut ObjectCloud,
) -> anyhow::Result<()> {
    let decoded = msg::cloud::to_points(&registered.cloud).context("the registered cloud")?;
    object.input_points = decoded.points.len() as u32;
    let frame = if registered.in_hand_frame {
        Frame::Hand { opening_m }
    } else {
        Frame::Camera
    };
    let Crop {
        points,
        up,
        removed,
    } = crop_or_nothing(cropper, &decoded.points, frame)?;
    object.empty = !cropper.is_object(points.len());
    object.up = msg::transform::from_vector(&up);
    object.cloud = msg::cloud::from_points(registered.header.clone(), &points);
    object.below_gripper = removed.below_gripper as u32;
    object.outside_cylinder = removed.outside_cylinder as u32;
    object.on_fingers = removed.on_fingers as u32;
    object.outliers = removed.outliers as u32;
    Ok(())
}

/// An empty hand is an answer, too.
fn crop_or_nothing(
    cropper: &Cropper,
    points: &[Point3<f32>],
    frame: Frame,
) -> Result<Crop, CropError> {
    match cropper.crop(points, frame) {
        Err(error @ CropError::NothingLeft { removed, .. }) => {
            // Perhaps the hand is not empty and the parameters do not fit: this says where to look.
            log::warn!("{error}");
            Ok(Crop {
                points: Vec::new(),
                up: cropper.up(frame),
                removed,
            })
        }
        other => other,
    }
}
