//! Random sequences of goals, cancellations, stops, callers that hang up, nodes that die, delays and lost answers, on a
//! simulated clock: each goal gets its result, the arm rests whenever a scan has ended, and after each sequence the next scan succeeds.
//!
//! SCAN_SEQUENCES says how many (default 1,000), SCAN_SEED which; the seed is printed.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod world;

use node::Life;
use scan_server::{GoalId, GoalServer, Outcome, Parameters, Scanner, Status};
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::time::{sleep, timeout};
use world::{Clients, Graph, World};

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

    /// A service call whose caller disconnects at a random time.
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
