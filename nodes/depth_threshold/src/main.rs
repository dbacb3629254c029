//! Turns depth images into the points between two depths.

use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use camera::{Camera, Picture};
use depth_threshold::{Calibration, Parameters, Thresholder};
use msg::sensor_msgs::{CameraInfo, PointCloud2};
use node::{Expect, Health, Latch, Level, Node};

mod camera;

const INFO_TOPIC: &str = "camera/depth/camera_info";

fn main() -> ExitCode {
    node::run("depth_threshold", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let thresholder = Thresholder::new(parameters.clone())?;
    let tuned = node.tune(parameters, Parameters::TUNABLES, Parameters::validate)?;
    let points = node.publish("points", 2, Latch::No)?;
    let latest_info = Arc::new(Mutex::new(None));
    let _infos = node.subscribe(INFO_TOPIC, Expect::STATE, {
        let latest_info = Arc::clone(&latest_info);
        move |info: CameraInfo| {
            *latest_info.lock().unwrap_or_else(PoisonError::into_inner) = Some(info)
        }
    })?;
    let stage = Mutex::new((thresholder, Reporter::new(node.health())));
    let camera = Camera::new(&node, move |topic, picture| {
        if !points.is_subscribed() {
            return;
        }
        let info = latest_info
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone();
        let mut stage = stage.lock().unwrap_or_else(PoisonError::into_inner);
        let (thresholder, reporter) = &mut *stage;
        let cloud = tune(thresholder, &tuned.now())
            .and_then(|()| threshold(thresholder, topic, picture, info.as_ref()));
        match cloud {
            Ok(cloud) => {
                reporter.well();
                points.send(cloud);
            }
            Err(error) => reporter.ill(&format!("{error:#}")),
        }
    });
    tokio::select! {
        () = node.until_shutdown() => Ok(()),
        error = camera.watch() => Err(error),
    }
}

/// Applies changed parameters to the thresholder.
fn tune(thresholder: &mut Thresholder, parameters: &Parameters) -> anyhow::Result<()> {
    if thresholder.parameters() != parameters {
        *thresholder = Thresholder::new(parameters.clone())?;
    }
    Ok(())
}

fn threshold(
    thresholder: &mut Thresholder,
    topic: &str,
    picture: Picture,
    info: Option<&CameraInfo>,
) -> anyhow::Result<PointCloud2> {
    let info = info.ok_or_else(|| {
        anyhow::anyhow!("no camera_info has come on {INFO_TOPIC}; does the camera publish it?")
    })?;
    let roi = &info.roi;
    let calibration = Calibration {
        width: info.width,
        height: info.height,
        d: &info.D,
        k: &info.K,
        p: &info.P,
        binning: [info.binning_x, info.binning_y],
        region: [roi.x_offset, roi.y_offset, roi.width, roi.height],
    };
    let intrinsics = calibration.intrinsics(topic)?;
    let points = picture.with_image(|image| thresholder.points(image, &intrinsics))??;
    Ok(msg::cloud::from_points(picture.into_header(), &points))
}

/// Reports each error once, not for each of thirty images a second.
struct Reporter {
    health: Health,
    trouble: Option<String>,
}

impl Reporter {
    fn new(health: Health) -> Self {
        Self {
            health,
            trouble: None,
        }
    }

    fn well(&mut self) {
        if self.trouble.take().is_some() {
            log::info!("depth images are usable again");
        }
        self.health.set("images", Level::Ok, "");
    }

    fn ill(&mut self, trouble: &str) {
        if self.trouble.as_deref() != Some(trouble) {
            log::error!("{trouble}");
            self.health.set("images", Level::Error, trouble);
            self.trouble = Some(trouble.to_owned());
        }
    }
}
