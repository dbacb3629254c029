//! One scan, from its first view to the complete cloud.

use std::time::Instant;

use anyhow::Context;
use icp_registration::{AxisTurn, Parameters, Registrar, TimeOffsets, ViewEvidence};
use msg::deformable_cobot::{RegisteredCloud, StageTime, View, ViewRegistration};
use msg::std_msgs::Header;
use msg::{Duration, timing};
use nalgebra::{Isometry3, Point3};
use parameter::ParameterError;

/// The views of one scan so far.
pub struct Scan {
    registrar: Registrar,
    offsets: TimeOffsets,
    /// Of the views' messages.
    pub(crate) scan_id: String,
    /// Views that the scan will have.
    pub(crate) count: u32,
    error: String,
    /// Stamp of the latest view, frame of the registered cloud.
    header: Header,
    views: Vec<ViewRegistration>,
    timing: Vec<StageTime>,
    /// The latest view, until it is known what it tells of the clocks: no answer waits for that.
    untold: Option<Placed>,
}

/// A view that was registered.
struct Placed {
    points: Vec<Point3<f32>>,
    wrist_rate: f64,
    kinematic: Isometry3<f64>,
    pose: Isometry3<f64>,
}

impl Scan {
    /// Without views.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn new(
        parameters: Parameters,
        scan_id: String,
        count: u32,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            registrar: Registrar::new(parameters)?,
            offsets: TimeOffsets::default(),
            scan_id,
            count,
            error: String::new(),
            header: Header::default(),
            views: Vec::new(),
            timing: Vec::new(),
            untold: None,
        })
    }

    /// Adds a view. One that fails ends the scan; what comes after it changes nothing.
    pub fn add(&mut self, view: &View) {
        if !self.error.is_empty() {
            return;
        }
        self.compare_clocks();
        self.header.stamp = view.header.stamp;
        for stage in &view.timing {
            self.spend(stage.clone());
        }
        let start = Instant::now();
        let result = self.register(view);
        self.spend(timing::stage("register", start.elapsed()));
        if let Err(error) = result {
            self.fail(&format!(
                "view {} of {}: {error:#}",
                self.views.len() + 1,
                self.count
            ));
        }
    }

    fn register(&mut self, view: &View) -> anyhow::Result<()> {
        anyhow::ensure!(view.error.is_empty(), "{}", view.error);
        let hand_from_camera = if view.has_pose {
            let pose = msg::transform::to_isometry(&view.hand_from_camera);
            Some(pose.context("hand_from_camera is no rotation and shift; look at /tf")?)
        } else {
            None
        };
        let decoded = msg::cloud::to_points(&view.cloud)?;
        if decoded.invalid > 0 {
            log::info!(
                "scan {}: left out {} points that are NaN or (0, 0, 0)",
                self.scan_id,
                decoded.invalid
            );
        }
        let evidence = self.registrar.add_view(&decoded.points, hand_from_camera)?;
        let kinematic = hand_from_camera.filter(|_| evidence.accepted);
        self.untold = kinematic.map(|kinematic| Placed {
            points: decoded.points,
            wrist_rate: view.wrist_rate,
            kinematic,
            pose: evidence.transform,
        });
        if !evidence.accepted {
            log::warn!(
                "scan {}: view {} refused: {}",
                self.scan_id,
                self.views.len() + 1,
                evidence.reason
            );
        }
        if self.views.is_empty() {
            let frame = if self.registrar.in_hand_frame() {
                &view.hand_frame
            } else {
                &view.header.frame_id
            };
            self.header.frame_id.clone_from(frame);
        }
        self.views.push(describe(
            self.views.len() as u32,
            view.wrist_angle,
            evidence,
        ));
        Ok(())
    }

    /// Does what the answer to the latest view did not need, but the next view will, or the scan's end.
    pub fn prepare(&mut self) {
        self.compare_clocks();
        if !self.is_complete() {
            self.registrar.prepare();
        }
    }

    fn compare_clocks(&mut self) {
        let Some(view) = self.untold.take() else {
            return;
        };
        let turn = match view.wrist_rate {
            0.0 => Ok(AxisTurn::default()),
            _ => self.registrar.axis_turn(&view.points, &view.pose),
        };
        match turn {
            Ok(turn) => {
                self.offsets
                    .note(view.wrist_rate, &view.kinematic, &view.pose, turn);
            }
            Err(error) => log::warn!("scan {}: {error}", self.scan_id),
        }
    }

    /// Ends the scan, for a reason of this stage.
    pub fn fail(&mut self, error: &str) {
        self.error = format!("icp_registration: {error}");
    }

    /// Ends the scan, for a reason of an earlier stage.
    pub fn pass_on(&mut self, view: &View) {
        self.header.stamp = view.header.stamp;
        self.error.clone_from(&view.error);
    }

    /// Ends the scan well, with the views so far.
    pub fn close(&mut self) {
        self.count = self.views.len() as u32;
    }

    /// Whether no more views count.
    pub fn is_complete(&self) -> bool {
        !self.error.is_empty() || self.views.len() >= self.count as usize
    }

    /// The cloud so far, or why there is none. What views tell of the clocks is in it from the view before on, and at the end of all.
    pub fn message(&mut self) -> RegisteredCloud {
        if self.is_complete() {
            self.compare_clocks();
        }
        let points = if self.error.is_empty() {
            self.registrar.cloud()
        } else {
            Vec::new()
        };
        let displacement = self.registrar.displacement();
        let offset = self.offsets.estimate();
        RegisteredCloud {
            header: self.header.clone(),
            scan_id: self.scan_id.clone(),
            error: self.error.clone(),
            count: self.count,
            view_count: self.views.len() as u32,
            complete: self.is_complete(),
            registered_count: self.registrar.count().registered,
            refused_count: self.registrar.count().refused,
            doubt: self.registrar.doubt().unwrap_or_default(),
            displacement: displacement.map_or(0.0, |hand| hand.sideways_m),
            tilt: displacement.map_or(0.0, |hand| hand.tilt_rad),
            time_offset: offset.map_or(0.0, |offset| offset.offset_s),
            time_offset_sigma: offset.map_or(0.0, |offset| offset.sigma_s),
            in_hand_frame: self.registrar.in_hand_frame(),
            views: self.views.clone(),
            coverage: self.registrar.coverage_rad(),
            cloud: msg::cloud::from_points(self.header.clone(), &points),
            timing: self.timing.clone(),
        }
    }

    /// Adds to what its stage took for the views before.
    fn spend(&mut self, time: StageTime) {
        match self
            .timing
            .iter_mut()
            .find(|known| known.stage == time.stage)
        {
            Some(known) => {
                known.elapsed = Duration::from_nanos(known.elapsed.nanos() + time.elapsed.nanos());
            }
            None => self.timing.push(time),
        }
    }
}

fn describe(index: u32, wrist_angle: f64, evidence: ViewEvidence) -> ViewRegistration {
    ViewRegistration {
        index,
        wrist_angle,
        transform: msg::transform::from_isometry(&evidence.transform),
        accepted: evidence.accepted,
        reason: evidence.reason,
        stop_reason: evidence.stop_reason.as_str().to_owned(),
        fitness: evidence.fitness,
        rmse: evidence.rmse_m,
        inliers: evidence.inliers as u32,
        iterations: evidence.iterations as u32,
        correction_translation: evidence.correction_m,
        correction_rotation: evidence.correction_rad,
        degenerate_directions: evidence.degenerate_directions as u32,
        object_gone: evidence.comparison.object.gone,
        object_new: evidence.comparison.object.new,
    }
}
