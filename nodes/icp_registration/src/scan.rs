//! One scan, from its first view to the complete cloud.

use std::time::Instant;

use anyhow::Context;
use icp_registration::{AxisTurn, Parameters, Registrar, TimeOffsets, ViewEvidence};
use msg::deformable_cobot::{RegisteredCloud, StageTime, View, ViewRegistration};
use msg::std_msgs::Header;
use msg::{Duration, timing};
use parameter::ParameterError;

/// The views of one scan so far.
pub struct Scan {
    registrar: Registrar,
    offsets: TimeOffsets,
    scan_id: String,
    count: u32,
    error: String,
    /// Stamp of the latest view, frame of the registered cloud.
    header: Header,
    views: Vec<ViewRegistration>,
    timing: Vec<StageTime>,
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
        })
    }

    /// Adds a view. One that fails ends the scan; what comes after it changes nothing.
    pub fn add(&mut self, view: &View) {
        if !self.error.is_empty() {
            return;
        }
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
        if let Some(kinematic) = &hand_from_camera
            && evidence.accepted
        {
            let pose = &evidence.transform;
            let turn = match view.wrist_rate {
                0.0 => AxisTurn::default(),
                _ => self.registrar.axis_turn(&decoded.points, pose)?,
            };
            self.offsets.note(view.wrist_rate, kinematic, pose, turn);
        }
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

    /// The cloud so far, or why there is none.
    pub fn message(&self) -> RegisteredCloud {
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

/// The scan that is under way on the topic of views.
pub struct Progress {
    parameters: Parameters,
    current: Option<Current>,
}

struct Current {
    scan: Scan,
    /// Index of the view that comes next; none comes any more once the scan ended, well or not.
    next: Option<u32>,
    /// Set while all that came of a scan is one view from its middle: perhaps the latched last word of a scan that
    /// ended before this node was started.
    first_seen: Option<u32>,
}

impl Progress {
    /// Before the first scan.
    pub fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            current: None,
        }
    }

    /// Registers by these from the next scan on.
    pub fn set_parameters(&mut self, parameters: &Parameters) {
        self.parameters.clone_from(parameters);
    }

    /// Forgets the scan under way, and takes no more views of it.
    pub fn abandon(&mut self) {
        if let Some(current) = &mut self.current {
            current.next = None;
            current.first_seen = None;
        }
    }

    /// What there is to publish after a view; nothing for one that came before.
    pub fn on_view(&mut self, view: View) -> Option<RegisteredCloud> {
        let is_new = self
            .current
            .as_ref()
            .is_none_or(|current| current.scan.scan_id != view.scan_id);
        if is_new {
            let scan = Scan::new(self.parameters.clone(), view.scan_id.clone(), view.count);
            // They were checked at the start.
            let scan = scan.inspect_err(|error| log::error!("{error}")).ok()?;
            let from_the_middle = view.index > 0 && view.kind != View::FAILED;
            let first_seen = from_the_middle.then_some(view.index);
            self.current = Some(Current {
                scan,
                next: Some(0),
                first_seen,
            });
            if from_the_middle {
                log::warn!(
                    "scan {}: its beginning was missed; waiting for another scan",
                    view.scan_id
                );
                return None;
            }
        }
        self.current.as_mut()?.on_view(&view)
    }
}

impl Current {
    fn on_view(&mut self, view: &View) -> Option<RegisteredCloud> {
        let next = self.next?;
        if view.kind == View::FAILED {
            self.scan.pass_on(view);
        } else if view.index < next || self.first_seen == Some(view.index) {
            return None;
        } else if view.index > next {
            let missing = next + 1;
            self.scan.fail(&format!(
                "view {missing} of {} never came; was this node started late?",
                view.count
            ));
        } else if view.kind == View::END {
            self.scan.close();
        } else {
            // A sweep knows only at its last view how many there were.
            self.scan.count = view.count;
            self.scan.add(view);
        }
        self.next = (!self.scan.is_complete()).then_some(next + 1);
        Some(self.scan.message())
    }
}

#[cfg(test)]
mod tests;
