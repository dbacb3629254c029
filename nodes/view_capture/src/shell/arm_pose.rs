//! How the hand stands before the camera, by TF and camera_info.

use anyhow::Context;
use msg::Time;
use msg::sensor_msgs::CameraInfo;
use nalgebra::Isometry3;
use node::transforms::TransformError;
use node::{Clock, Expect, Node, Subscriber, Transforms};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::{Instant, sleep};
use view_capture::{ImagePlane, Parameters};

const INFO_TOPIC: &str = "camera/depth/camera_info";
/// Pause between two looks at TF.
const TF_PERIOD: Duration = Duration::from_millis(50);
/// The pose is that of so long ago, which TF has already reached. Before a motion the arm is still.
const TF_AGE_NS: i64 = 100_000_000;

/// Checks that the camera can see what the hand holds. Clones share it.
#[derive(Clone)]
pub struct ArmPose {
    transforms: Transforms,
    infos: watch::Receiver<Option<Arc<CameraInfo>>>,
    clock: Arc<Clock>,
    _link: Subscriber,
}

impl ArmPose {
    pub fn listen(node: &Node, transforms: Transforms) -> anyhow::Result<Self> {
        let (latest, infos) = watch::channel(None);
        let link = node.subscribe(INFO_TOPIC, Expect::STATE, move |info: CameraInfo| {
            latest.send_replace(Some(Arc::new(info)));
        })?;
        Ok(Self {
            transforms,
            infos,
            clock: node.clock(),
            _link: link,
        })
    }

    /// Is the gripper upright, and the place of the object in the camera's range and image?
    pub async fn check(&self, parameters: &Parameters) -> anyhow::Result<()> {
        let rules = parameters.pose_rules();
        rules.check_upright(&self.hand_in(&parameters.base_frame, parameters).await?)?;
        let info = self
            .info(Duration::from_secs_f64(parameters.frame_deadline_s))
            .await?;
        let image = ImagePlane {
            fx: info.K[0],
            fy: info.K[4],
            cx: info.K[2],
            cy: info.K[5],
            width: f64::from(info.width),
            height: f64::from(info.height),
        };
        let camera_from_hand = self.hand_in(&info.header.frame_id, parameters).await?;
        rules.check_in_view(&camera_from_hand, &image)?;
        Ok(())
    }

    /// frame_from_hand as it was just now. TF that has only just begun is waited for, too.
    async fn hand_in(
        &self,
        frame: &str,
        parameters: &Parameters,
    ) -> Result<Isometry3<f64>, TransformError> {
        let deadline = Instant::now() + Duration::from_secs_f64(parameters.transform_deadline_s);
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let hand = parameters.side.hand_frame();
            let stamp_ns = (self.clock.now().nanos() - TF_AGE_NS).max(0);
            let stamp = Time::from_nanos(stamp_ns);
            match self.transforms.wait(frame, hand, stamp, left).await {
                Err(TransformError::TooOld { .. }) if !left.is_zero() => sleep(TF_PERIOD).await,
                found => return found,
            }
        }
    }

    async fn info(&self, patience: Duration) -> anyhow::Result<Arc<CameraInfo>> {
        let mut infos = self.infos.clone();
        let first = tokio::time::timeout(patience, infos.wait_for(Option::is_some)).await;
        let info = first
            .ok()
            .and_then(Result::ok)
            .and_then(|info| info.clone());
        info.with_context(|| {
            format!(
                "no camera_info came on {INFO_TOPIC} within {patience:.1?}; is the camera running?"
            )
        })
    }
}
