//! The running graph, as a scan needs it.

use super::diagnostics::Diagnostics;
use anyhow::{Context, ensure};
use baxter::WristPlan;
use msg::deformable_cobot::{CaptureViews, CaptureViewsReq, PlanViews, PlanViewsReq, View};
use msg::sensor_msgs::PointCloud2;
use msg::view::{end, failed};
use node::{CallError, Clock, Count, Expect, Latch, Life, Node, Publisher, Subscriber};
use scan_server::{Parameters, Stages, Wish};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast;
use tokio::time::Instant;

/// How long `plan_views` may take, with a view_capture that has just been started again.
const PLAN_DEADLINE: Duration = Duration::from_secs(5);
/// How long a scan waits for somebody to register its views: a node that has just been started again is soon there.
const LISTENER_PATIENCE: Duration = Duration::from_secs(5);

/// Views of a sweep kept until they are handed on, which takes a millisecond each.
const CAPTURED_KEPT: usize = 16;

/// The other nodes.
pub struct Graph {
    node: Node,
    view_deadline: Duration,
    diagnostics: Diagnostics,
    clock: Arc<Clock>,
    views: Publisher<View>,
    clouds: Publisher<PointCloud2>,
    /// How often `stop_wrist` was called.
    stops: Count,
    captured: broadcast::Sender<Arc<View>>,
    _link: Subscriber,
}

impl Graph {
    pub fn new(node: &Node, parameters: &Parameters) -> anyhow::Result<Self> {
        let captured = broadcast::Sender::new(CAPTURED_KEPT);
        let link = node.subscribe("captured", Expect::EVENTS, {
            let captured = captured.clone();
            move |view: View| {
                // Nobody listens between scans.
                let _ = captured.send(Arc::new(view));
            }
        })?;
        Ok(Self {
            node: node.clone(),
            view_deadline: Duration::from_secs_f64(parameters.view_deadline_s),
            diagnostics: Diagnostics::listen(node)?,
            clock: node.clock(),
            views: node.publish("views", 16, Latch::Yes)?,
            clouds: node.publish("views/cloud", 4, Latch::Yes)?,
            stops: node.follow_count("wrist_stops")?,
            captured,
            _link: link,
        })
    }
}

impl Stages for Graph {
    async fn plan(&self, wish: Wish, life: &Life) -> anyhow::Result<WristPlan> {
        let request = PlanViewsReq {
            views: wish.views,
            range: wish.range_rad,
        };
        let called = self
            .node
            .call::<PlanViews>("plan_views", request, PLAN_DEADLINE, life);
        let planned = called.await.map_err(reason)?;
        ensure!(planned.error.is_empty(), "{}", planned.error);
        if planned.range == 0.0 {
            return Ok(WristPlan::Rests(planned.angles));
        }
        Ok(WristPlan::Sweep {
            range_rad: planned.range,
            count: planned.count,
        })
    }

    fn until_wrist_stopped(&self, life: &Life) -> Life {
        let stopped = self.stops.until_changed();
        life.and_until(async {
            stopped.await;
            "stop_wrist was called".to_owned()
        })
    }

    async fn until_registered(&self) -> anyhow::Result<()> {
        ensure!(
            self.views.until_subscribed(LISTENER_PATIENCE).await,
            "nobody listens to 'views' (waited {LISTENER_PATIENCE:.1?}); is icp_registration running?"
        );
        Ok(())
    }

    async fn capture(&self, angle_rad: f64, life: &Life) -> anyhow::Result<View> {
        let request = CaptureViewsReq {
            angles: vec![angle_rad],
            ..Default::default()
        };
        let called =
            self.node
                .call::<CaptureViews>("capture_views", request, self.view_deadline, life);
        let mut captured = called.await.map_err(reason)?;
        ensure!(
            captured.error.is_empty(),
            "view_capture: {}",
            captured.error
        );
        captured
            .views
            .pop()
            .context("capture_views gave no view and no reason")
    }

    async fn sweep(
        &self,
        range_rad: f64,
        count: u32,
        scan_id: &str,
        life: &Life,
    ) -> anyhow::Result<u32> {
        let request = CaptureViewsReq {
            range: range_rad,
            scan_id: scan_id.into(),
            ..Default::default()
        };
        let deadline = self.view_deadline.saturating_mul(count.max(1));
        let called = self
            .node
            .call::<CaptureViews>("capture_views", request, deadline, life);
        let captured = called.await.map_err(reason)?;
        ensure!(
            captured.error.is_empty(),
            "view_capture: {}",
            captured.error
        );
        Ok(captured.count)
    }

    fn captured(&self) -> broadcast::Receiver<Arc<View>> {
        self.captured.subscribe()
    }

    fn publish(&self, view: View) {
        if self.clouds.is_subscribed() {
            self.clouds.send(view.cloud.clone());
        }
        self.views.send(view);
    }

    fn publish_end(&self, scan_id: &str, view_count: u32) {
        self.views.send(end(scan_id, view_count, self.clock.now()));
    }

    fn publish_failure(&self, scan_id: &str, error: String) {
        self.views.send(failed(scan_id, error, self.clock.now()));
    }

    async fn diagnosis(&self, since: Instant) -> String {
        self.diagnostics.clause(since).await
    }

    fn silent_stages(&self) -> Vec<&'static str> {
        self.diagnostics.silent_stages()
    }
}

/// Who gave a call up knows better why than the call.
fn reason(error: CallError) -> anyhow::Error {
    match error {
        CallError::GivenUp { reason, .. } => anyhow::anyhow!(reason),
        error => error.into(),
    }
}
