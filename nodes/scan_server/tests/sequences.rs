//! Random sequences of goals, cancellations, stops, callers that hang up, nodes that die, delays and lost answers, on a
//! simulated clock: each goal gets its result, the arm rests whenever a scan has ended, and after each sequence the next scan succeeds.
//!
//! SCAN_SEQUENCES says how many (default 1,000), SCAN_SEED which; the seed is printed.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use anyhow::{bail, ensure};
use baxter::WristPlan;
use msg::deformable_cobot::{Classification, ScanObjectResult, View};
use node::Life;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use scan_server::{
    GoalId, GoalServer, GoalState, Outcome, Parameters, Scanner, Stages, Status, Topics, Wish,
};
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};
use std::time::Duration;
use tokio::sync::{broadcast, watch};
use tokio::time::{Instant, sleep, timeout};

/// What nodes other than the scan server take at most to answer or to be given up.
const CALL_DEADLINE: Duration = Duration::from_secs(30);
/// How long the arm takes to come to rest.
const RAMP: Duration = Duration::from_millis(250);

/// The rest of the graph, which does as it should or does not.
struct World {
    random: Mutex<Pcg64Mcg>,
    /// Whether nodes fail now.
    is_faulty: AtomicBool,
    is_moving: AtomicBool,
    /// Whether somebody listens to the action's results.
    is_heard: watch::Sender<bool>,
    is_ending: watch::Sender<bool>,
    results: Mutex<HashMap<String, Vec<(Status, String)>>>,
    scanner: OnceLock<Weak<Scanner<Graph>>>,
    captured: broadcast::Sender<Arc<View>>,
}

struct Graph(Arc<World>);
struct Clients(Arc<World>);

impl World {
    fn new(seed: u64) -> Arc<Self> {
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

    fn below(&self, end: u64) -> u64 {
        self.random.lock().unwrap().random_range(0..end)
    }

    fn millis(&self, end: u64) -> Duration {
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

/// A scan server in a world.
struct Bench {
    world: Arc<World>,
    scanner: Arc<Scanner<Graph>>,
    server: Arc<GoalServer<Clients>>,
    serving: tokio::task::JoinHandle<()>,
    /// Names of all goals.
    asked: HashSet<String>,
    callers: Vec<tokio::task::JoinHandle<()>>,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let world = World::new(seed);
        let parameters = Parameters {
            stop_when_confident: if world.below(2) == 0 { 0.0 } else { 0.7 },
            ..Default::default()
        };
        let scanner = Arc::new(Scanner::new(Graph(Arc::clone(&world)), parameters));
        assert!(world.scanner.set(Arc::downgrade(&scanner)).is_ok());
        let server = Arc::new(GoalServer::new(Clients(Arc::clone(&world))));
        let serving = tokio::spawn({
            let (world, scanner, server) = (
                Arc::clone(&world),
                Arc::clone(&scanner),
                Arc::clone(&server),
            );
            async move {
                let mut ending = world.is_ending.subscribe();
                let shutdown = Life::until(async move {
                    let _ = ending.wait_for(|ending| *ending).await;
                    "the node is shutting down".into()
                });
                server.serve(&scanner, &shutdown).await;
            }
        });
        Self {
            world,
            scanner,
            server,
            serving,
            asked: HashSet::new(),
            callers: Vec::new(),
        }
    }

    fn send_goal(&mut self, name: String, views: u32) {
        self.asked.insert(name.clone());
        self.server.on_goal(
            GoalId {
                id: name,
                stamp_ns: 0,
            },
            views,
        );
    }

    /// A goal of before, or none.
    fn any_goal(&self) -> String {
        let mut names: Vec<_> = self.asked.iter().cloned().collect();
        names.sort();
        let index = self.world.below(1 + names.len() as u64) as usize;
        names.get(index).cloned().unwrap_or_default()
    }

    /// A caller of the service, who hangs up some time.
    fn call_service(&mut self) {
        let (world, scanner) = (Arc::clone(&self.world), Arc::clone(&self.scanner));
        let (patience, views) = (world.millis(60_000), world.below(5) as u32);
        self.callers.push(tokio::spawn(async move {
            let life = Life::until(async move {
                sleep(patience).await;
                "the caller hung up".into()
            });
            let scanned = scanner.scan(views, &life).await;
            let is_other = scanned.answer.error.contains("already running");
            assert!(is_other || !world.is_moving.load(Ordering::Relaxed));
        }));
    }

    async fn do_something(&mut self) {
        match self.world.below(10) {
            0..4 => {
                let views = self.world.below(70) as u32;
                let views = if views < 60 { views % 5 } else { views };
                self.send_goal(format!("goal {}", self.asked.len()), views);
            }
            4 => {
                let (name, views) = (self.any_goal(), 2);
                if !name.is_empty() {
                    self.send_goal(name, views);
                }
            }
            5 | 6 => {
                let id = self.any_goal();
                self.server.on_cancel(&GoalId { id, stamp_ns: 0 });
            }
            7 => self.call_service(),
            8 => {
                self.world.is_heard.send_replace(false);
                sleep(self.world.millis(100)).await;
                self.world.is_heard.send_replace(true);
            }
            _ => {}
        }
        let pause = [50, 1_000, 10_000][self.world.below(3) as usize];
        sleep(self.world.millis(pause)).await;
    }

    /// Waits until all goals and calls have ended.
    async fn settle(&mut self) {
        let ended = async {
            for caller in self.callers.drain(..) {
                caller.await.unwrap();
            }
            while self.asked.len() > self.world.results.lock().unwrap().len() {
                sleep(Duration::from_millis(100)).await;
            }
        };
        let ended = timeout(Duration::from_secs(3_600), ended).await;
        assert!(ended.is_ok(), "a goal without result");
        assert!(!self.world.is_moving.load(Ordering::Relaxed));
    }
}

async fn run(seed: u64) {
    let mut bench = Bench::new(seed);
    for _ in 0..bench.world.below(12) {
        bench.do_something().await;
    }
    if bench.world.below(4) == 0 {
        bench.world.is_ending.send_replace(true);
        bench.settle().await;
        let serving = timeout(Duration::from_secs(5), bench.serving).await;
        assert!(serving.is_ok(), "the server does not end");
        bench.server.on_goal(
            GoalId {
                id: "late".into(),
                stamp_ns: 0,
            },
            1,
        );
        let results = bench.world.results.lock().unwrap();
        assert_eq!(results["late"][0].0, Status::Recalled);
        return;
    }
    bench.settle().await;
    bench.world.is_faulty.store(false, Ordering::Relaxed);
    // What the classifier was late with is out of the way.
    sleep(Duration::from_secs(10)).await;
    if bench.world.below(2) == 0 {
        let life = Life::until(std::future::pending());
        let scanned = bench
            .scanner
            .scan(if seed.is_multiple_of(2) { 0 } else { 3 }, &life)
            .await;
        assert_eq!(
            (scanned.outcome, &scanned.answer.error[..]),
            (Outcome::Succeeded, "")
        );
    } else {
        bench.send_goal("next".into(), 3);
        bench.settle().await;
        let results = bench.world.results.lock().unwrap();
        assert_eq!(results["next"], [(Status::Succeeded, String::new())]);
    }
    bench.serving.abort();
}

#[test]
fn after_each_sequence_the_next_scan_succeeds() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse().unwrap());
    let sequences = number("SCAN_SEQUENCES").unwrap_or(1_000);
    let first_seed = number("SCAN_SEED").unwrap_or_else(rand::random::<u64>);
    for seed in (0..sequences).map(|index| first_seed.wrapping_add(index)) {
        println!("SCAN_SEED={seed}");
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .start_paused(true)
            .build()
            .unwrap();
        runtime.block_on(run(seed));
    }
}
