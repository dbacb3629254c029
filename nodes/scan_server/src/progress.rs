//! How far a scan has come, told to all who watch.

use msg::deformable_cobot::{Classification, ScanObjectFeedback};
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;

/// Pause between two reports while the wrist turns.
const REPORT_PERIOD: Duration = Duration::from_millis(100);

/// How near the wrist is to its target when it is told to look: wrist_rotator's tolerance is 0.0087 rad.
const ARRIVED_RAD: f64 = 0.01;

/// What a scan is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The wrist turns to the next angle.
    Turning,
    /// It is there; the view is waited for.
    Looking,
    /// All views are taken; the classifier's answer is waited for.
    Classifying,
    /// Ended with an answer.
    Done,
    /// Ended without.
    Failed,
    /// Ended because somebody wished so.
    Stopped,
}

impl State {
    fn name(self) -> &'static str {
        match self {
            Self::Turning => "turning",
            Self::Looking => "looking",
            Self::Classifying => "classifying",
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Stopped => "stopped",
        }
    }
}

/// The newest report; written by the scan, the joint states and the classifier's answers. Clones share it.
#[derive(Clone)]
pub struct Progress {
    report: Arc<watch::Sender<ScanObjectFeedback>>,
    /// Since when the scan does what it does.
    since: Arc<Mutex<Instant>>,
}

impl Default for Progress {
    fn default() -> Self {
        Self::new()
    }
}

impl Progress {
    /// Of no scan yet.
    pub fn new() -> Self {
        let report = ScanObjectFeedback {
            wrist_angle: f64::NAN,
            ..Default::default()
        };
        Self {
            report: Arc::new(watch::Sender::new(report)),
            since: Arc::new(Mutex::new(Instant::now())),
        }
    }

    /// A scan of `count` views begins.
    pub fn begin(&self, scan_id: &str, count: u32) {
        self.report.send_modify(|report| {
            *report = ScanObjectFeedback {
                scan_id: scan_id.into(),
                state: State::Turning.name().into(),
                view: 1,
                count,
                wrist_angle: report.wrist_angle,
                target_angle: report.wrist_angle,
                ..Default::default()
            }
        });
    }

    /// The wrist turns to where the view `index` (from 0) is to be taken.
    pub fn turning(&self, index: u32, target_rad: f64) {
        self.mark();
        self.report.send_modify(|report| {
            report.state = State::Turning.name().into();
            report.view = index + 1;
            report.target_angle = target_rad;
        });
    }

    /// A view was taken.
    pub fn taken(&self, points: u32) {
        self.report.send_modify(|report| report.points = points);
    }

    /// So many views of a sweep were left out so far.
    pub fn left_out(&self, count: u32) {
        self.report.send_modify(|report| report.left_out = count);
    }

    /// The scan does something else now.
    pub fn set(&self, state: State) {
        self.mark();
        self.report
            .send_modify(|report| report.state = state.name().into());
    }

    /// Since when the scan turns to a view, or waits for the classifier.
    pub fn since(&self) -> Instant {
        *self.since.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn mark(&self) {
        *self.since.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// The wrist is at an angle, rad. Told with the next report, or at once where the wrist has come to where it turns.
    pub fn note_angle(&self, angle_rad: f64) {
        self.report.send_if_modified(|report| {
            report.wrist_angle = angle_rad;
            let has_arrived = report.state == State::Turning.name()
                && (angle_rad - report.target_angle).abs() < ARRIVED_RAD;
            if has_arrived {
                report.state = State::Looking.name().into();
            }
            has_arrived
        });
    }

    /// The classifier has said something, perhaps about the scan under way.
    pub fn note_answer(&self, answer: &Classification) {
        self.report.send_if_modified(|report| {
            let is_news = answer.scan_id == report.scan_id
                && answer.error.is_empty()
                && answer.view_count > report.view_count;
            if is_news {
                report.view_count = answer.view_count;
                report.label.clone_from(&answer.label);
                report.probability = answer.probability;
                report.known = answer.known;
            }
            is_news
        });
    }

    /// Calls `tell` with each change, and often while the wrist turns.
    pub async fn follow(&self, tell: impl Fn(ScanObjectFeedback)) -> Infallible {
        let mut changes = self.report.subscribe();
        loop {
            let is_turning = changes.borrow().state == State::Turning.name();
            tokio::select! {
                // Its sender lives as long as this does.
                _ = changes.changed() => {}
                () = tokio::time::sleep(REPORT_PERIOD), if is_turning => {}
            }
            let report = changes.borrow_and_update().clone();
            tell(report);
        }
    }
}
