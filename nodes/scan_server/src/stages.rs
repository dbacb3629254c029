//! What a scan is asked for, and what it needs of the other nodes.

use baxter::WristPlan;
use msg::deformable_cobot::View;
use node::Life;
use std::sync::Arc;
use tokio::sync::broadcast;
use tokio::time::Instant;

/// What a caller asks for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wish {
    /// How many views at rest; 0: as configured.
    pub views: u32,
    /// Angle through which the wrist sweeps, rad; 0: as view_capture is configured.
    pub range_rad: f64,
}

impl From<u32> for Wish {
    fn from(views: u32) -> Self {
        Self {
            views,
            range_rad: 0.0,
        }
    }
}

/// What a scan needs of the running graph. All futures end when `life` does; the arm rests then.
pub trait Stages: Send + Sync {
    /// How to take the views that are asked for.
    fn plan(
        &self,
        wish: Wish,
        life: &Life,
    ) -> impl Future<Output = anyhow::Result<WristPlan>> + Send;
    /// `life`, which ends also when `stop_wrist` is called: also between two turns, when nothing moves.
    fn until_wrist_stopped(&self, life: &Life) -> Life;
    /// Waits until somebody registers views, so that the first one is not lost.
    fn until_registered(&self) -> impl Future<Output = anyhow::Result<()>> + Send;
    /// Turns the wrist to an angle and takes the view there.
    fn capture(
        &self,
        angle_rad: f64,
        life: &Life,
    ) -> impl Future<Output = anyhow::Result<View>> + Send;
    /// Turns the wrist through a range, with views meanwhile, which come by [`Stages::captured`] with this scan id; says how
    /// many were taken. Of `count` views it may leave some out.
    fn sweep(
        &self,
        range_rad: f64,
        count: u32,
        scan_id: &str,
        life: &Life,
    ) -> impl Future<Output = anyhow::Result<u32>> + Send;
    /// The views of sweeps from now on.
    fn captured(&self) -> broadcast::Receiver<Arc<View>>;
    /// Hands a view on to the later stages.
    fn publish(&self, view: View);
    /// Tells the later stages that no more views come than these.
    fn publish_end(&self, scan_id: &str, view_count: u32);
    /// Tells the later stages that the scan ended without an answer.
    fn publish_failure(&self, scan_id: &str, error: String);
    /// A clause for an error text: what the nodes have said is wrong with them since a moment; empty where they say nothing.
    fn diagnosis(&self, since: Instant) -> impl Future<Output = String> + Send;
    /// The stages after the views that are not running.
    fn silent_stages(&self) -> Vec<&'static str>;
}
