//! The rest of the graph: nodes that are late, fail, or lose answers, and clients that leave.

use anyhow::{bail, ensure};
use baxter::WristPlan;
use msg::deformable_cobot::{Classification, ScanObjectResult, View};
use node::Life;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use scan_server::{GoalState, Scanner, Stages, Status, Topics, Wish};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::time::Duration;
use tokio::sync::{broadcast, watch};
use tokio::time::{Instant, sleep};

/// What nodes other than the scan server take at most to answer or to be given up.
const CALL_DEADLINE: Duration = Duration::from_secs(30);
/// How long the arm takes to come to rest.
const RAMP: Duration = Duration::from_millis(250);

/// The rest of the graph, which does as it should or does not.
pub struct World {
    random: Mutex<Pcg64Mcg>,
    /// Whether nodes fail now.
    pub is_faulty: AtomicBool,
    pub is_moving: AtomicBool,
    /// Whether somebody listens to the action's results.
    pub is_heard: watch::Sender<bool>,
    pub is_ending: watch::Sender<bool>,
    pub results: Mutex<HashMap<String, Vec<(Status, String)>>>,
    pub scanner: OnceLock<Weak<Scanner<Graph>>>,
    captured: broadcast::Sender<Arc<View>>,
}

/// The nodes that a scan goes through.
pub struct Graph(pub Arc<World>);
/// Who asks for scans.
pub struct Clients(pub Arc<World>);

impl World {
    pub fn new(seed: u64) -> Arc<Self> {
        Arc::new(Self {
            random: Mutex::new(Pcg64Mcg::seed_from_u64(seed)),
            is_faulty: AtomicBool::new(true),
            is_moving: AtomicBool::new(false),
            is_heard: watch::Sender::new(true),
            is_ending: watch::Sender::new(false),
            results: Mutex::default(),
            scanner: OnceLock::new(),
            captured: broadcast::Sender::new(16),
        })
    }

    pub fn below(&self, end: u64) -> u64 {
        self.random.lock().unwrap().random_range(0..end)
    }

    pub fn millis(&self, end: u64) -> Duration {
        Duration::from_millis(self.below(end))
    }

    /// Whether something goes wrong now that does so once in `rarity` times.
    fn fails(&self, rarity: u64) -> bool {
        self.is_faulty.load(Ordering::Relaxed) && self.below(rarity) == 0
    }

    /// A call of another node, as `Node::call` makes it: it may fail, or never be answered.
    async fn call(&self, usual_ms: u64, life: &Life) -> anyhow::Result<()> {
        let lasts = match () {
            () if self.fails(12) => CALL_DEADLINE,
            () => self.millis(usual_ms),
        };
        tokio::select! {
            reason = life.ended() => bail!("{reason}"),
            () = sleep(lasts) => {}
        }
        ensure!(lasts < CALL_DEADLINE, "no answer within {CALL_DEADLINE:?}");
        ensure!(!self.fails(12), "its node has died");
        Ok(())
    }

    /// The classifier's answer to a message on `views`.
    fn answer(self: &Arc<Self>, view: View) {
        if self.fails(8) {
            return;
        }
        let late = if self.fails(20) { 8_000 } else { 50 };
        let (delay, times) = (self.millis(late), 1 + self.below(2));
        let is_end = view.kind == View::END;
        let broken = self.fails(20);
        let answer = Classification {
            scan_id: view.scan_id,
            view_count: view.index + u32::from(!is_end),
            complete: is_end || broken || view.index + 1 == view.count,
            label: "cup".into(),
            known: true,
            probability: self.below(100) as f64 / 100.0,
            error: if broken {
                "roi_crop: broken".into()
            } else {
                view.error
            },
            ..Default::default()
        };
        let world = Arc::clone(self);
        tokio::spawn(async move {
            sleep(delay).await;
            if let Some(scanner) = world.scanner.get().and_then(Weak::upgrade) {
                (0..times).for_each(|_| scanner.note_answer(answer.clone()));
            }
        });
    }
}

impl Stages for Graph {
    async fn plan(&self, wish: Wish, life: &Life) -> anyhow::Result<WristPlan> {
        self.0.call(20, life).await?;
        let Wish { views, range_rad } = wish;
        ensure!(views <= 64, "{views} views");
        let sweeps_by_itself = views == 0 && self.0.below(2) == 0;
        if sweeps_by_itself || range_rad != 0.0 {
            return Ok(WristPlan::Sweep {
                range_rad: range_rad.max(1.2),
                count: 13,
            });
        }
        let views = if views == 0 { 3 } else { views };
        Ok(WristPlan::Rests((0..views).map(f64::from).collect()))
    }

    async fn sweep(&self, _: f64, count: u32, scan_id: &str, life: &Life) -> anyhow::Result<u32> {
        let world = &self.0;
        assert!(
            !world.is_moving.swap(true, Ordering::Relaxed),
            "two motions at once"
        );
        let mut taken = 0;
        let swept = loop {
            if let Err(error) = world.call(100, life).await {
                break Err(error);
            }
            // A camera, or the way here, may be slow.
            if world.below(4) == 0 && taken + 1 < count {
                continue;
            }
            taken += 1;
            let is_last = taken >= count || world.below(20) == 0;
            let _ = world.captured.send(Arc::new(View {
                scan_id: scan_id.into(),
                index: taken - 1,
                count: if is_last { taken } else { count },
                ..Default::default()
            }));
            if is_last {
                break Ok(taken);
            }
        };
        if swept.is_err() {
            sleep(RAMP).await;
        }
        world.is_moving.store(false, Ordering::Relaxed);
        swept
    }

    fn captured(&self) -> broadcast::Receiver<Arc<View>> {
        self.0.captured.subscribe()
    }

    fn until_wrist_stopped(&self, life: &Life) -> Life {
        if !self.0.fails(10) {
            return life.clone();
        }
        let stopped = sleep(self.0.millis(10_000));
        life.and_until(async {
            stopped.await;
            "stop_wrist was called".into()
        })
    }

    async fn until_registered(&self) -> anyhow::Result<()> {
        ensure!(!self.0.fails(20), "nobody listens to 'views'");
        Ok(())
    }

    async fn capture(&self, angle_rad: f64, life: &Life) -> anyhow::Result<View> {
        assert!(
            !self.0.is_moving.swap(true, Ordering::Relaxed),
            "two motions at once"
        );
        let called = self.0.call(1_500, life).await;
        if called.is_err() {
            sleep(RAMP).await;
        }
        self.0.is_moving.store(false, Ordering::Relaxed);
        called?;
        Ok(View {
            wrist_angle: angle_rad,
            ..Default::default()
        })
    }

    fn publish(&self, view: View) {
        self.0.answer(view);
    }

    fn publish_end(&self, scan_id: &str, view_count: u32) {
        self.0
            .answer(msg::view::end(scan_id, view_count, msg::Time::default()));
    }

    fn publish_failure(&self, scan_id: &str, error: String) {
        self.0
            .answer(msg::view::failed(scan_id, error, msg::Time::default()));
    }

    async fn diagnosis(&self, _: Instant) -> String {
        sleep(Duration::from_millis(1_200)).await;
        String::new()
    }

    fn silent_stages(&self) -> Vec<&'static str> {
        Vec::new()
    }
}

impl Topics for Clients {
    fn publish_statuses(&self, _: &[GoalState]) {}

    fn publish_result(&self, goal: &GoalState, result: &ScanObjectResult) {
        let mut results = self.0.results.lock().unwrap();
        let of_goal = results.entry(goal.id.id.clone()).or_default();
        of_goal.push((goal.status, result.error.clone()));
        assert!(
            of_goal.iter().all(|other| *other == of_goal[0]),
            "{of_goal:?}"
        );
        assert_eq!(goal.status == Status::Succeeded, result.error.is_empty());
    }

    async fn until_nobody_listens(&self) -> String {
        let (mut heard, mut ending) = (self.0.is_heard.subscribe(), self.0.is_ending.subscribe());
        tokio::select! {
            _ = heard.wait_for(|heard| !heard) => "nobody listens".into(),
            _ = ending.wait_for(|ending| *ending) => "the node is shutting down".into(),
        }
    }
}
