//! Whether a scan is taking its views.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use msg::deformable_cobot::ScanObjectFeedback;
use node::{Expect, Node, Subscriber};

/// A scan that reports nothing for so long has died. While the wrist turns there are ten reports a second, and a cloud is
/// waited for no longer than this.
const REPORT_AGE_MAX: Duration = Duration::from_secs(10);

/// Listens to the reports of scans.
pub struct ScanWatch {
    /// When a scan that takes views was last heard of; none once it has its views.
    heard: Arc<Mutex<Option<Instant>>>,
    _reports: Subscriber,
}

impl ScanWatch {
    /// Listens to `progress`.
    ///
    /// # Errors
    /// The topic cannot be subscribed to.
    pub fn listen(node: &Node) -> anyhow::Result<Self> {
        let heard = Arc::new(Mutex::new(None));
        let _reports = node.subscribe("progress", Expect::EVENTS, {
            let heard = Arc::clone(&heard);
            move |report: ScanObjectFeedback| {
                let takes_views = matches!(&report.state[..], "turning" | "looking");
                let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
                *heard = takes_views.then(Instant::now);
            }
        })?;
        Ok(Self { heard, _reports })
    }

    /// Refuses what must not happen while a scan takes its views.
    ///
    /// # Errors
    /// One does.
    pub fn refuse_during_scan(&self) -> anyhow::Result<()> {
        let heard = *self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        let is_under_way = heard.is_some_and(|heard| heard.elapsed() < REPORT_AGE_MAX);
        anyhow::ensure!(
            !is_under_way,
            "a scan is taking its views; wait for its end, or set during_scan to drop or swap the object on purpose"
        );
        Ok(())
    }
}
