//! Scans found in what somebody else makes the robot do. Views are published as they come.

use super::clouds::Shot;
use super::view::{timing, view_of};
use super::watched::{Event, Watched};
use msg::deformable_cobot::View;
use msg::sensor_msgs::{JointState, PointCloud2};
use msg::view::{failed, new_scan_id};
use msg::{Time, robot};
use node::transforms::TransformError;
use node::{Clock, Expect, Latch, Node, Publisher, Transforms, Tuned};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::mpsc;
use view_capture::{Parameters, PassageView, RestView, ScanView, Sweep};

/// Joint states kept while a cloud is looked at: in passive mode each counts, not only the newest.
const JOINT_STATES: Expect = Expect {
    queue: 100,
    ..Expect::STATE
};

/// Views kept for a slow subscriber: those of a sweep come all at once, at its end.
const VIEWS_KEPT: usize = 64;

/// Images that are older than the first transform by less than this are skipped, s: rosbag begins to record each topic at a
/// different time. A larger difference means clock skew, which is an error.
const BEFORE_TF_MAX_S: f64 = 2.0;

/// Watches until shutdown.
pub async fn watch(
    node: &Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
) -> anyhow::Result<()> {
    let mut scans = Scans::new(node, parameters.clone(), transforms)?;
    let watched = Arc::new(Mutex::new(Watched::new(&parameters.now())));
    let (events, mut heard) = mpsc::unbounded_channel();
    let hand_on = {
        let events = events.clone();
        move |event: Option<Event>| {
            if let Some(event) = event {
                // Fails only while the node shuts down, as below.
                let _ = events.send(event);
            }
        }
    };
    let _points = node.subscribe("points", Expect::STATE, {
        let (watched, clock, hand_on) = (Arc::clone(&watched), node.clock(), hand_on.clone());
        move |cloud: PointCloud2| {
            let arrived = clock.now();
            hand_on(lock(&watched).on_cloud(Arc::new(Shot { cloud, arrived })));
        }
    })?;
    let _joints = node.subscribe("/robot/joint_states", JOINT_STATES, {
        let (watched, parameters) = (Arc::clone(&watched), parameters.clone());
        let joint = parameters.now().side.wrist_joint();
        move |state: JointState| {
            // Most messages on the topic are about other joints.
            let sample = robot::joint_sample(&state, joint);
            if let Some(sample) = sample.filter(|sample| sample.angle_rad.is_finite()) {
                let mut watched = lock(&watched);
                watched.set_rules(&parameters.now());
                hand_on(watched.on_joint(sample));
            }
        }
    })?;
    node.clock().on_jump({
        let watched = Arc::clone(&watched);
        move || {
            lock(&watched).reset();
            let _ = events.send(Event::Jumped);
        }
    });
    loop {
        let event = tokio::select! {
            () = node.until_shutdown() => return Ok(()),
            Some(event) = heard.recv() => event,
        };
        match event {
            Event::Rested(view) => {
                if let Err(BeforeTf(stamp)) = scans.add(view).await {
                    lock(&watched).take_back(stamp);
                }
            }
            Event::Swept(views) => scans.add_sweep(views).await,
            Event::Jumped => scans.forget(),
        }
    }
}

/// Makes scans of what was seen, and publishes them.
struct Scans {
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
    clock: Arc<Clock>,
    views: Publisher<View>,
    clouds: Publisher<PointCloud2>,
    sweep: Sweep<Arc<View>>,
    /// The scan whose views are not all published yet.
    unfinished: Option<Unfinished>,
}

/// The stamp of an image that was taken shortly before the first transform.
struct BeforeTf(Time);

struct Unfinished {
    number: u64,
    id: String,
    view_count: usize,
}

impl Scans {
    fn new(
        node: &Node,
        parameters: Tuned<Parameters>,
        transforms: Option<Transforms>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            sweep: Sweep::new(parameters.now().sweep_rules()),
            parameters,
            transforms,
            clock: node.clock(),
            views: node.publish("views", VIEWS_KEPT, Latch::Yes)?,
            clouds: node.publish("views/cloud", 4, Latch::Yes)?,
            unfinished: None,
        })
    }

    /// The hand's pose is looked up at once: TF is soon forgotten.
    async fn add(&mut self, rested: RestView<Arc<Shot>>) -> Result<(), BeforeTf> {
        let parameters = self.parameters.now();
        self.sweep.set_rules(parameters.sweep_rules());
        let (shot, angle_rad) = (&rested.cloud, rested.angle_rad);
        let moment = shot.cloud.header.stamp;
        match view_of(
            shot,
            moment,
            angle_rad,
            &parameters,
            self.transforms.as_ref(),
        )
        .await
        {
            Ok(mut view) => {
                view.timing = timing(shot, self.clock.now());
                let views = self.sweep.add(RestView {
                    angle_rad,
                    cloud: Arc::new(view),
                    moved: rested.moved,
                });
                views.into_iter().for_each(|view| self.publish(view));
            }
            Err(error) if is_before_tf(&error) => {
                log::info!("an image at {angle_rad:.2} rad is left out: {error:#}");
                return Err(BeforeTf(moment));
            }
            Err(error) => {
                self.sweep.reset();
                self.fail(&format!("the view at {angle_rad:.2} rad: {error:#}"));
            }
        }
        Ok(())
    }

    /// Publishes the views of a sweep, which has ended; without the first ones, where they are older than TF.
    async fn add_sweep(&mut self, swept: Vec<PassageView<Arc<Shot>>>) {
        let scan_id = new_scan_id();
        let views = match self.views_of_sweep(swept).await {
            Ok(views) => views,
            Err(error) => {
                log::error!("scan {scan_id}: {error}");
                let error = format!("view_capture: {error}");
                return self.views.send(failed(&scan_id, error, self.clock.now()));
            }
        };
        let count = views.len() as u32;
        log::info!("scan {scan_id}: {count} views of a sweep");
        for (index, view) in (0..).zip(views) {
            let scan_id = scan_id.clone();
            self.send(View {
                scan_id,
                index,
                count,
                ..view
            });
        }
    }

    async fn views_of_sweep(
        &self,
        swept: Vec<PassageView<Arc<Shot>>>,
    ) -> Result<Vec<View>, String> {
        let parameters = self.parameters.now();
        let mut views = Vec::with_capacity(swept.len());
        let last = swept.len().saturating_sub(1);
        for (number, seen) in swept.into_iter().enumerate() {
            let (shot, angle_rad) = (&seen.cloud, seen.angle_rad);
            let moment = shot.cloud.header.stamp;
            let transforms = self.transforms.as_ref();
            match view_of(shot, moment, angle_rad, &parameters, transforms).await {
                Ok(view) => views.push(View {
                    wrist_rate: seen.rate_rad_s,
                    timing: timing(shot, self.clock.now()),
                    ..view
                }),
                Err(error) if views.is_empty() && number < last && is_before_tf(&error) => {
                    log::info!("an image at {angle_rad:.2} rad is left out: {error:#}");
                }
                Err(error) => return Err(format!("the view at {angle_rad:.2} rad: {error:#}")),
            }
        }
        Ok(views)
    }

    fn publish(&mut self, found: ScanView<Arc<View>>) {
        if let Some(scan) = &self.unfinished
            && scan.number != found.scan
        {
            let seen = scan.view_count;
            self.fail(&format!(
                "the wrist turned back after {seen} of {} views",
                found.count
            ));
        }
        let scan = self.unfinished.get_or_insert_with(|| Unfinished {
            number: found.scan,
            id: new_scan_id(),
            view_count: 0,
        });
        let (index, count) = (found.index, found.count);
        log::info!("scan {}: view {} of {count} seen", scan.id, index + 1);
        let view = View {
            scan_id: scan.id.clone(),
            index: index as u32,
            count: count as u32,
            ..(*found.view.cloud).clone()
        };
        scan.view_count = index + 1;
        if scan.view_count == count {
            self.unfinished = None;
        }
        self.send(view);
    }

    fn send(&self, view: View) {
        if self.clouds.is_subscribed() {
            self.clouds.send(view.cloud.clone());
        }
        self.views.send(view);
    }

    /// Ends the scan under way, or one that ends before its first view.
    fn fail(&mut self, error: &str) {
        let id = self
            .unfinished
            .take()
            .map_or_else(new_scan_id, |scan| scan.id);
        log::error!("scan {id}: {error}");
        let error = format!("view_capture: {error}");
        self.views.send(failed(&id, error, self.clock.now()));
    }

    /// Begins anew after ROS time was set; the later stages do so by themselves.
    fn forget(&mut self) {
        self.sweep.reset();
        self.unfinished = None;
    }
}

fn is_before_tf(error: &anyhow::Error) -> bool {
    matches!(error.downcast_ref(), Some(TransformError::TooOld { late_s, .. }) if *late_s < BEFORE_TF_MAX_S)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
