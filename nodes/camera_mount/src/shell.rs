//! The calibration's ROS service: requests a sweep of the wrist, collects its views, calibrates, and answers.

use std::fmt::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::{Context, ensure};
use camera_mount::calibration::{self, Calibration, View, calibrate};
use camera_mount::{CameraMount, file, steady_views};
use msg::deformable_cobot::{
    CalibrateCameraMount, CalibrateCameraMountReq, CalibrateCameraMountRes, CaptureViews,
    CaptureViewsReq, View as ViewMessage,
};
use msg::tf2_msgs::TFMessage;
use nalgebra::{Isometry3, Vector6};
use node::{Life, Node, Publisher, Server, Transforms};

/// Time limit for TF to provide the frames of a received view.
const TRANSFORM_PATIENCE: Duration = Duration::from_secs(2);

/// Offers the calibration, until dropped.
pub struct Service {
    _server: Server,
}

struct Calibrator {
    node: Node,
    transforms: Transforms,
    fixed: Publisher<TFMessage>,
    mount: Mutex<CameraMount>,
    sweeps: tokio::sync::Mutex<Vec<Vec<Seen>>>,
}

/// A view independent of the mount, which may have changed by the time the view is used.
struct Seen {
    hand_from_parent: Isometry3<f64>,
    points: Vec<nalgebra::Point3<f32>>,
}

impl Service {
    pub fn offer(
        node: &Node,
        mount: CameraMount,
        fixed: Publisher<TFMessage>,
    ) -> anyhow::Result<Self> {
        let calibrator = Calibrator {
            node: node.clone(),
            transforms: node.transforms()?,
            fixed,
            mount: Mutex::new(mount),
            sweeps: tokio::sync::Mutex::default(),
        };
        let calibrator = Arc::new(calibrator);
        let server =
            node.serve::<CalibrateCameraMount>("calibrate_camera_mount", move |request, life| {
                let calibrator = Arc::clone(&calibrator);
                async move { Ok(calibrator.answer(request, &life).await) }
            })?;
        Ok(Self { _server: server })
    }
}

impl Calibrator {
    async fn answer(
        &self,
        request: CalibrateCameraMountReq,
        life: &Life,
    ) -> CalibrateCameraMountRes {
        match self.sweep_and_calibrate(&request, life).await {
            Ok(response) => response,
            Err(error) => {
                log::error!("calibrate_camera_mount: {error:#}");
                CalibrateCameraMountRes {
                    error: format!("{error:#}"),
                    ..Default::default()
                }
            }
        }
    }

    async fn sweep_and_calibrate(
        &self,
        request: &CalibrateCameraMountReq,
        life: &Life,
    ) -> anyhow::Result<CalibrateCameraMountRes> {
        let mut sweeps = self
            .sweeps
            .try_lock()
            .context("a calibration is already running; call again when it has ended")?;
        let mount = lock(&self.mount).clone();
        let (sweep, camera_from_optical) = self.sweep(&mount, request.views, life).await?;
        if !request.add {
            sweeps.clear();
        }
        sweeps.push(sweep);
        let parent_from_optical = mount.parent_from_camera() * camera_from_optical;
        let views = |sweep: &Vec<Seen>| -> Vec<View> {
            let view = |seen: &Seen| View {
                hand_from_camera: seen.hand_from_parent * parent_from_optical,
                points: seen.points.clone(),
            };
            sweep.iter().map(view).collect()
        };
        let believed: Vec<Vec<View>> = sweeps.iter().map(views).collect();
        let found = tokio::task::spawn_blocking(move || calibrate(&believed)).await?;
        // Drop a failed sweep, so that it does not spoil the calibrations with later sweeps.
        let found = found.inspect_err(|_| drop(sweeps.pop()))?;
        let parent_from_camera =
            parent_from_optical * found.believed_from_actual * camera_from_optical.inverse();
        let new = mount.moved_to(&parent_from_camera);
        new.validate()?;
        if request.write {
            file::write(&new, &mount.calibration.file)?;
            self.node.change_parameters(&new);
            self.fixed
                .send(crate::static_transform(&new, self.node.clock().now()));
            *lock(&self.mount) = new.clone();
        }
        let response = response(&mount, &new, &found, &camera_from_optical);
        Ok(CalibrateCameraMountRes {
            sweep_count: sweeps.len() as u32,
            view_count: sweeps.iter().map(Vec::len).sum::<usize>() as u32,
            ..response
        })
    }

    /// Requests views of the object in hand: `views` at rest, or, for 0, those of a sweep. Returns them, and
    /// camera_from_optical.
    async fn sweep(
        &self,
        mount: &CameraMount,
        views: u32,
        life: &Life,
    ) -> anyhow::Result<(Vec<Seen>, Isometry3<f64>)> {
        let (range, view_count) = (mount.calibration.range_rad, mount.calibration.view_count);
        let deadline = Duration::from_secs_f64(mount.calibration.deadline_s);
        let is_sweep = views == 0 && range > 0.0;
        let request = CaptureViewsReq {
            views: if views == 0 { view_count } else { views },
            range: if is_sweep { range } else { 0.0 },
            ..Default::default()
        };
        let captured = self
            .node
            .call::<CaptureViews>("capture_views", request, deadline, life)
            .await?;
        ensure!(
            captured.error.is_empty(),
            "view_capture: {}",
            captured.error
        );
        let used = if is_sweep {
            let rates_rad_s: Vec<f64> = captured.views.iter().map(|view| view.wrist_rate).collect();
            let used = steady_views(&rates_rad_s, view_count as usize);
            ensure!(
                used.len() == view_count as usize,
                "only {} views came while the wrist turned, and {view_count} are needed: the camera or this machine is slow; \
                 call with views: {view_count}, at rest for each",
                used.len()
            );
            used
        } else {
            (0..captured.views.len()).collect()
        };
        let mut sweep = Vec::new();
        let mut camera_from_optical = Isometry3::identity();
        for view in used
            .into_iter()
            .filter_map(|number| captured.views.get(number))
        {
            let (seen, from_optical) = self.seen(mount, view).await?;
            sweep.push(seen);
            camera_from_optical = from_optical;
        }
        Ok((sweep, camera_from_optical))
    }

    async fn seen(
        &self,
        mount: &CameraMount,
        view: &ViewMessage,
    ) -> anyhow::Result<(Seen, Isometry3<f64>)> {
        ensure!(
            view.has_pose,
            "views have no pose: view_capture must use TF (~use_tf)"
        );
        let hand_from_optical = msg::transform::to_isometry(&view.hand_from_camera)
            .context("hand_from_camera is no rotation and shift; look at /tf")?;
        let optical = &view.header.frame_id;
        let transforms = &self.transforms;
        let look_up =
            |target| transforms.wait(target, optical, view.header.stamp, TRANSFORM_PATIENCE);
        let parent_from_optical = look_up(&mount.parent_frame).await?;
        let camera_from_optical = look_up(&mount.child_frame).await?;
        let seen = Seen {
            hand_from_parent: hand_from_optical * parent_from_optical.inverse(),
            points: msg::cloud::to_points(&view.cloud)?.points,
        };
        Ok((seen, camera_from_optical))
    }
}

fn response(
    old: &CameraMount,
    new: &CameraMount,
    found: &Calibration,
    camera_from_optical: &Isometry3<f64>,
) -> CalibrateCameraMountRes {
    let in_camera = found.seen_from(camera_from_optical);
    let (turn_sigma, shift_sigma) = in_camera.sigmas();
    let change = old.parent_from_camera().inverse() * new.parent_from_camera();
    let mount = file::content(new);
    log::info!(
        "the camera mount is off by {:.2}° and {:.1} mm; surfaces agree to {:.2} mm (before: {:.2} mm)\n{mount}",
        change.rotation.angle().to_degrees(),
        1e3 * change.translation.vector.norm(),
        1e3 * found.after_m,
        1e3 * found.before_m,
    );
    CalibrateCameraMountRes {
        success: true,
        mount,
        parent_from_camera: msg::transform::from_isometry(&new.parent_from_camera()),
        rotation_sigma: msg::transform::from_vector(&turn_sigma),
        translation_sigma: msg::transform::from_vector(&shift_sigma),
        undetermined: in_camera
            .open
            .iter()
            .map(|motion| in_words(motion, &new.child_frame))
            .collect(),
        change_rotation: change.rotation.angle(),
        change_translation: change.translation.vector.norm(),
        disagreement_before: found.before_m,
        disagreement_after: found.after_m,
        ..Default::default()
    }
}

/// Describes a motion that is still open, and how to determine it.
fn in_words(motion: &Vector6<f64>, frame: &str) -> String {
    let (turn, shift) = calibration::turn_and_shift(motion);
    let mut text = String::new();
    let axis = |vector: nalgebra::Vector3<f64>| {
        let axis = vector.normalize();
        format!("({:.2}, {:.2}, {:.2})", axis.x, axis.y, axis.z)
    };
    let (turned, shifted) = (turn.norm().to_degrees(), 1e3 * shift.norm());
    if turned > 0.1 {
        let _ = write!(text, "a turn by ±{turned:.1}° about {}", axis(turn));
    }
    if shifted > 0.5 {
        let joint = if text.is_empty() { "" } else { " with " };
        let _ = write!(
            text,
            "{joint}a shift by ±{shifted:.0} mm along {}",
            axis(shift)
        );
    }
    format!("{text} of {frame}: lean or move the arm, and call again with add: true")
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
