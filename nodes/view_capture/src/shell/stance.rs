//! How the hand stands before the camera, by TF and camera_info.

use anyhow::Context;
use msg::sensor_msgs::CameraInfo;
use node::{Clock, Expect, Node, Subscriber, Transforms};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use view_capture::{ImagePlane, Parameters};

const INFO_TOPIC: &str = "camera/depth/camera_info";

/// Looks whether a scan makes sense where the hand is. Clones share it.
#[derive(Clone)]
pub struct Stance {
    transforms: Transforms,
    infos: watch::Receiver<Option<Arc<CameraInfo>>>,
    clock: Arc<Clock>,
    _link: Subscriber,
}

impl Stance {
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
        let hand = &parameters.hand_frame;
        let now = self.clock.now();
        let patience = Duration::from_secs_f64(parameters.transform_deadline_s);
        let pose_in = async |frame: &str| self.transforms.wait(frame, hand, now, patience).await;
        rules.check_upright(&pose_in(&parameters.base_frame).await?)?;
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
        rules.check_in_view(&pose_in(&info.header.frame_id).await?, &image)?;
        Ok(())
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
