//! How far a scan has come, told to all who watch.

use super::output::Place;
use msg::deformable_cobot::{Classification, ScanObjectFeedback};
use node::{Latch, Node};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// Pause between two reports while the wrist turns.
const REPORT_PERIOD: Duration = Duration::from_millis(100);

/// What a scan is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The wrist turns to the next angle.
    Turning,
    /// It is at rest; a cloud is waited for.
    Looking,
    /// All views are taken; the answer is waited for.
    Thinking,
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
            Self::Thinking => "thinking",
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
}

impl Progress {
    pub fn new() -> Self {
        let report = ScanObjectFeedback {
            wrist_angle: f64::NAN,
            ..Default::default()
        };
        Self {
            report: Arc::new(watch::Sender::new(report)),
        }
    }

    /// A scan begins.
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

    /// The wrist turns to where a view is to be taken.
    pub fn turning(&self, place: &Place, target_rad: f64) {
        self.report.send_modify(|report| {
            report.state = State::Turning.name().into();
            report.view = place.index + 1;
            report.target_angle = target_rad;
        });
    }

    /// A view was taken.
    pub fn taken(&self, points: u32) {
        self.report.send_modify(|report| report.points = points);
    }

    /// The scan does something else now.
    pub fn is(&self, state: State) {
        self.report
            .send_modify(|report| report.state = state.name().into());
    }

    /// The wrist is at an angle. Told with the next report.
    pub fn note_angle(&self, angle_rad: f64) {
        self.report.send_if_modified(|report| {
            report.wrist_angle = angle_rad;
            false
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

    /// Publishes on `progress`.
    pub async fn publish(&self, node: &Node) -> anyhow::Result<Infallible> {
        let topic = node.publish("progress", 4, Latch::Yes)?;
        Ok(self.follow(move |report| topic.send(report)).await)
    }
}
