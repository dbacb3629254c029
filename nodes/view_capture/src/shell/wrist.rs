//! The wrist, turned through `wrist_rotator`.

use anyhow::ensure;
use msg::deformable_cobot::{RotateWrist, RotateWristReq, RotateWristRes};
use node::{Life, Node};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Mutex;

/// Turns the wrist, one turn at a time. Clones share it.
#[derive(Clone)]
pub struct Wrist {
    node: Node,
    /// Held while it turns.
    turning: Arc<Mutex<()>>,
}

impl Wrist {
    pub fn new(node: &Node) -> Self {
        Self {
            node: node.clone(),
            turning: Arc::default(),
        }
    }

    /// Turns the wrist to an angle and waits until it is at rest there. Where `life` ends before, `wrist_rotator` ends the
    /// turn, and this returns once the wrist is at rest.
    pub async fn turn(
        &self,
        angle_rad: f64,
        deadline: Duration,
        life: &Life,
    ) -> anyhow::Result<RotateWristRes> {
        let _turning = self.turning.lock().await;
        let request = RotateWristReq { angle: angle_rad };
        let call = self
            .node
            .call::<RotateWrist>("rotate_wrist", request, deadline, life);
        let turned = call.await?;
        ensure!(turned.success, "rotate_wrist: {}", turned.error);
        Ok(turned)
    }

    /// Waits until no turn is under way.
    pub async fn until_at_rest(&self) {
        let _still = self.turning.lock().await;
    }
}
