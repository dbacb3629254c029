//! The wrist, turned and stopped through `wrist_rotator`.

use anyhow::ensure;
use msg::deformable_cobot::{RotateWrist, RotateWristReq, RotateWristRes};
use msg::std_srvs::{Trigger, TriggerReq};
use node::Node;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long `stop_wrist` may take: it waits until the arm is still.
const STOP_DEADLINE: Duration = Duration::from_secs(5);

/// Turns the wrist, one turn at a time. Clones share it.
#[derive(Clone)]
pub struct Wrist {
    node: Node,
    /// Set also after a turn whose end was not waited for.
    is_turning: Arc<AtomicBool>,
}

impl Wrist {
    pub fn new(node: &Node) -> Self {
        Self {
            node: node.clone(),
            is_turning: Arc::default(),
        }
    }

    /// Turns the wrist to an angle and waits until it is at rest there. Dropped before, it hangs up, and `wrist_rotator`
    /// ends the turn.
    pub async fn turn(&self, angle_rad: f64, deadline: Duration) -> anyhow::Result<RotateWristRes> {
        let request = RotateWristReq { angle: angle_rad };
        self.is_turning.store(true, Ordering::Relaxed);
        let call = self
            .node
            .call::<RotateWrist>("rotate_wrist", request, deadline);
        let turned = call.await?;
        self.is_turning.store(false, Ordering::Relaxed);
        ensure!(turned.success, "rotate_wrist: {}", turned.error);
        Ok(turned)
    }

    /// Waits until the arm is still after a turn that was dropped.
    pub async fn stop(&self) {
        if !self.is_turning.swap(false, Ordering::Relaxed) {
            return;
        }
        let stopped = self
            .node
            .call::<Trigger>("stop_wrist", TriggerReq {}, STOP_DEADLINE);
        match stopped.await {
            Ok(stopped) if stopped.success => {}
            Ok(stopped) => log::error!("stop_wrist: {}", stopped.message),
            Err(error) => log::error!("{error}"),
        }
    }
}
