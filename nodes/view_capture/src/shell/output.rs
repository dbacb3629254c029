//! What a scan puts on its topics.

use msg::Time;
use msg::deformable_cobot::{StageTime, View};
use msg::sensor_msgs::PointCloud2;
use msg::timing;
use nalgebra::Isometry3;
use node::{Clock, Latch, Node, Publisher, Transforms};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use view_capture::Parameters;

/// The publishers of views. Clones share them.
#[derive(Clone)]
pub struct Output {
    views: Publisher<View>,
    clouds: Publisher<PointCloud2>,
    clock: Arc<Clock>,
}

/// A cloud, and when it came.
#[derive(Debug, PartialEq)]
pub struct Shot {
    pub cloud: PointCloud2,
    pub arrived: Time,
}

impl Shot {
    /// How old the image was when its cloud came, and how long it has since been kept until the wrist was known to rest.
    fn timing(&self, now: Time) -> Vec<StageTime> {
        let between = |begin: Time, end: Time| {
            let elapsed_ns = (end - begin).nanos().max(0);
            Duration::from_nanos(elapsed_ns as u64)
        };
        vec![
            timing::stage("capture", between(self.cloud.header.stamp, self.arrived)),
            timing::stage("settle", between(self.arrived, now)),
        ]
    }
}

/// Which view of which scan.
#[derive(Debug, Clone)]
pub struct Place {
    pub scan_id: String,
    pub index: u32,
    pub count: u32,
}

/// Where the hand was when the camera looked.
#[derive(Debug, Clone)]
pub struct Pose {
    pub hand_frame: String,
    pub hand_from_camera: Isometry3<f64>,
}

impl Pose {
    /// The pose at the stamp of `cloud`, waited for as configured; `None` where TF is not used.
    pub async fn at(
        parameters: &Parameters,
        transforms: Option<&Transforms>,
        cloud: &PointCloud2,
    ) -> anyhow::Result<Option<Self>> {
        let Some(transforms) = transforms else {
            return Ok(None);
        };
        let hand_frame = parameters.side.hand_frame();
        let patience = Duration::from_secs_f64(parameters.transform_deadline_s);
        let header = &cloud.header;
        let pose = transforms
            .wait(hand_frame, &header.frame_id, header.stamp, patience)
            .await;
        Ok(Some(Self {
            hand_from_camera: pose?,
            hand_frame: hand_frame.into(),
        }))
    }
}

impl Output {
    pub fn new(node: &Node) -> anyhow::Result<Self> {
        Ok(Self {
            views: node.publish("views", 16, Latch::Yes)?,
            clouds: node.publish("views/cloud", 4, Latch::Yes)?,
            clock: node.clock(),
        })
    }

    /// Waits until somebody listens to the views, so that the first one is not lost.
    pub async fn wait_for_listener(&self, patience: Duration) -> anyhow::Result<()> {
        anyhow::ensure!(
            self.views.until_subscribed(patience).await,
            "nobody listens to 'views' (waited {patience:.1?}); is icp_registration running?"
        );
        Ok(())
    }

    /// Publishes a view, and its cloud alone where somebody looks at it.
    pub fn view(&self, place: Place, angle_rad: f64, pose: Option<Pose>, shot: &Shot) {
        let cloud = &shot.cloud;
        if self.clouds.is_subscribed() {
            self.clouds.send(cloud.clone());
        }
        let mut view = View {
            header: cloud.header.clone(),
            scan_id: place.scan_id,
            index: place.index,
            count: place.count,
            wrist_angle: angle_rad,
            cloud: cloud.clone(),
            timing: shot.timing(self.clock.now()),
            ..Default::default()
        };
        if let Some(pose) = pose {
            view.has_pose = true;
            view.hand_frame = pose.hand_frame;
            view.hand_from_camera = msg::transform::from_isometry(&pose.hand_from_camera);
        }
        self.views.send(view);
    }

    /// Says that no more views come than these; the later stages then end the scan with what they have.
    pub fn end_early(&self, scan_id: &str, views: u32) {
        let mut end = View {
            scan_id: scan_id.into(),
            index: views,
            count: views,
            ..Default::default()
        };
        end.header.stamp = self.clock.now();
        self.views.send(end);
    }

    /// Ends the scan with an error that every later stage passes on.
    pub fn failure(&self, place: Place, error: String) {
        let mut view = View {
            scan_id: place.scan_id,
            index: place.index,
            count: place.count,
            error,
            ..Default::default()
        };
        view.header.stamp = self.clock.now();
        self.views.send(view);
    }
}

/// A name that no other scan has, also after the time of a simulation was set back: from the computer's own clock.
pub fn new_scan_id() -> String {
    static SCANS: AtomicU32 = AtomicU32::new(0);
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    format!(
        "{:x}-{}",
        now.as_millis(),
        SCANS.fetch_add(1, Ordering::Relaxed)
    )
}
