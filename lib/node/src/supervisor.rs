//! The thread that looks after a node's links: repeats, redials, and registers again with a master that forgot.

use crate::clock::Clock;
use crate::environment;
use crate::health::Health;
use crate::link::Tended;
use crate::memory;
use crate::sockets::Sockets;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

const TICK: Duration = Duration::from_millis(20);
const TEND_PERIOD: Duration = Duration::from_millis(200);
const SOCKETS_PERIOD: Duration = Duration::from_millis(250);
const REPORT_PERIOD: Duration = Duration::from_secs(1);
/// Returned memory costs milliseconds when it is needed again: seldom enough for few views to pay, often enough for a node to
/// stay small.
const MEMORY_PERIOD: Duration = Duration::from_secs(3);
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

/// Starts the threads: for time, diagnostics and memory, for sockets, and one each for the links and the master, which may
/// wait for the network.
pub(crate) fn start(duties: Duties) -> std::io::Result<()> {
    let Duties {
        registry,
        clock,
        health,
        restore,
    } = duties;
    let links = Arc::clone(&registry);
    spawn("supervisor", TICK, {
        let (mut reported, mut returned) = (Instant::now(), Instant::now());
        move || {
            clock.observe(rosrust::now());
            if reported.elapsed() >= REPORT_PERIOD {
                reported = Instant::now();
                let links = links.living();
                health.publish(links.iter().filter_map(|link| link.report()).collect());
            }
            if returned.elapsed() >= MEMORY_PERIOD {
                returned = Instant::now();
                memory::return_free();
            }
        }
    })?;
    // By itself: what holds up the others may be what it ends.
    let (ended, ends) = std::sync::mpsc::channel();
    spawn("sockets", SOCKETS_PERIOD, {
        let mut sockets = Sockets::new(&environment::master_uri());
        move || {
            // Nobody receives while the node goes.
            let _ = ended.send(sockets.tend());
        }
    })?;
    let links = Arc::clone(&registry);
    spawn("links", TEND_PERIOD, move || {
        links.living().iter().for_each(|link| link.tend());
        let gone: Vec<_> = ends.try_iter().flatten().collect();
        links.living().iter().for_each(|link| link.lost(&gone));
    })?;
    spawn("master watch", MASTER_PERIOD, {
        let mut master = MasterWatch::default();
        move || {
            if master.forgot_us() {
                log::warn!("the ROS master was restarted; registering again");
                restore();
                registry.living().iter().for_each(|link| link.renew());
            }
        }
    })
}

/// Does `work` after each `period` while the node runs.
fn spawn(
    name: &str,
    period: Duration,
    mut work: impl FnMut() + Send + 'static,
) -> std::io::Result<()> {
    let thread = std::thread::Builder::new().name(name.into());
    thread.spawn(move || {
        while rosrust::is_ok() {
            std::thread::sleep(period);
            work();
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
        // Asked first, since rosrust waits for a master out of reach as long as TCP does.
        let state = environment::check_master().map(|()| rosrust::state());
        match state {
            Ok(Ok(state)) => {
                if std::mem::take(&mut self.unreachable) {
                    log::info!("the ROS master answers again");
                }
                !state
                    .publishers
                    .iter()
                    .any(|topic| topic.connections.contains(&name))
            }
            _ => {
                if !std::mem::replace(&mut self.unreachable, true) {
                    log::warn!("the ROS master does not answer; links that exist go on");
                }
                false
            }
        }
    }
}
