//! The thread that looks after a node's links: repeats, redials, and registers again with a master that forgot.

use crate::clock::Clock;
use crate::health::Health;
use crate::link::Tended;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

const TICK: Duration = Duration::from_millis(20);
const TEND_PERIOD: Duration = Duration::from_millis(200);
const REPORT_PERIOD: Duration = Duration::from_secs(1);
const MASTER_PERIOD: Duration = Duration::from_secs(2);

/// All links of the node.
#[derive(Default)]
pub(crate) struct Registry {
    links: Mutex<Vec<Weak<dyn Tended>>>,
    closed: AtomicBool,
}

impl Registry {
    pub fn add(&self, link: &Arc<dyn Tended>) {
        self.links
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(Arc::downgrade(link));
    }

    /// Unregisters all links and lets none be renewed: the node is going.
    pub fn close(&self) {
        let links = self.living();
        self.closed.store(true, Ordering::Relaxed);
        links.iter().for_each(|link| link.close());
    }

    fn living(&self) -> Vec<Arc<dyn Tended>> {
        if self.closed.load(Ordering::Relaxed) {
            return Vec::new();
        }
        let mut links = self.links.lock().unwrap_or_else(PoisonError::into_inner);
        links.retain(|link| link.strong_count() > 0);
        links.iter().filter_map(Weak::upgrade).collect()
    }
}

/// What the supervisor looks after.
pub(crate) struct Duties {
    pub registry: Arc<Registry>,
    pub clock: Arc<Clock>,
    pub health: Health,
    /// Restores what a restarted master forgot besides the links.
    pub restore: Box<dyn Fn() + Send>,
}

/// Starts the two threads: one for time and repeats, one for what may block on the network.
pub(crate) fn start(duties: Duties) -> std::io::Result<()> {
    let Duties {
        registry,
        clock,
        health,
        restore,
    } = duties;
    let links = Arc::clone(&registry);
    std::thread::Builder::new()
        .name("supervisor".into())
        .spawn(move || {
            let mut tended = Instant::now();
            let mut reported = Instant::now();
            while rosrust::is_ok() {
                std::thread::sleep(TICK);
                clock.observe(rosrust::now());
                if tended.elapsed() >= TEND_PERIOD {
                    tended = Instant::now();
                    links.living().iter().for_each(|link| link.tend());
                }
                if reported.elapsed() >= REPORT_PERIOD {
                    reported = Instant::now();
                    let reports = links
                        .living()
                        .iter()
                        .filter_map(|link| link.report())
                        .collect();
                    health.publish(reports);
                }
            }
        })?;
    std::thread::Builder::new()
        .name("master watch".into())
        .spawn(move || {
            let mut master = MasterWatch::default();
            while rosrust::is_ok() {
                std::thread::sleep(MASTER_PERIOD);
                if master.forgot_us() {
                    log::warn!("the ROS master was restarted; registering again");
                    restore();
                    registry.living().iter().for_each(|link| link.renew());
                }
            }
        })?;
    Ok(())
}

#[derive(Default)]
struct MasterWatch {
    unreachable: bool,
}

impl MasterWatch {
    /// Whether a master answers that knows nothing of this node: each node publishes at least its diagnostics.
    fn forgot_us(&mut self) -> bool {
        let name = rosrust::name();
        match rosrust::state() {
            Ok(state) => {
                self.unreachable = false;
                !state
                    .publishers
                    .iter()
                    .any(|topic| topic.connections.contains(&name))
            }
            Err(_) => {
                if !std::mem::replace(&mut self.unreachable, true) {
                    log::warn!("the ROS master does not answer; links that exist go on");
                }
                false
            }
        }
    }
}
