//! ROS time, and the news that it jumped back.

use rosrust::Time;
use std::sync::Mutex;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::watch;

/// Steps back that are no jump: stamps from several computers are not in order to the millisecond.
const JUMP_MIN_NS: i64 = 500_000_000;

/// Simulated time, ns; this where the computer's own counts.
const WALL_CLOCK: i64 = i64::MIN;
static SIMULATED_NS: AtomicI64 = AtomicI64::new(WALL_CLOCK);

/// ROS time now; zero while simulated time has not begun.
pub(crate) fn now() -> Time {
    match SIMULATED_NS.load(Ordering::Relaxed) {
        WALL_CLOCK => {
            let since_epoch = SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .unwrap_or_default();
            Time::from_nanos(i64::try_from(since_epoch.as_nanos()).unwrap_or(i64::MAX))
        }
        simulated_ns => Time::from_nanos(simulated_ns),
    }
}

/// From now on simulated time counts, and it is `now`.
pub(crate) fn simulate(now: Time) {
    SIMULATED_NS.store(now.nanos(), Ordering::Relaxed);
}

/// ROS time: the computer's, or /clock's where `/use_sim_time` is set.
///
/// A bag that loops, and a simulation that starts again, set it back. What was remembered belongs to another past then;
/// [`Clock::jumps`] tells.
pub struct Clock {
    latest_ns: AtomicI64,
    jumps: watch::Sender<u64>,
    on_jump: Mutex<Vec<Box<dyn Fn() + Send>>>,
}

impl Clock {
    pub(crate) fn new() -> Self {
        Self {
            latest_ns: AtomicI64::new(i64::MIN),
            jumps: watch::Sender::new(0),
            on_jump: Mutex::default(),
        }
    }

    /// The time now; zero while simulated time has not begun.
    pub fn now(&self) -> Time {
        now()
    }

    /// Counts the jumps back since the node started.
    pub fn jumps(&self) -> watch::Receiver<u64> {
        self.jumps.subscribe()
    }

    /// Calls `forget` at each jump back, before [`Clock::jumps`] changes.
    pub fn on_jump(&self, forget: impl Fn() + Send + 'static) {
        if let Ok(mut callbacks) = self.on_jump.lock() {
            callbacks.push(Box::new(forget));
        }
    }

    /// Compares the time with the latest seen. Called often.
    pub(crate) fn observe(&self, now: Time) {
        let now_ns = now.nanos();
        let latest_ns = self.latest_ns.swap(now_ns, Ordering::Relaxed);
        if latest_ns != i64::MIN && now_ns < latest_ns.saturating_sub(JUMP_MIN_NS) {
            log::warn!(
                "time jumped back by {:.1} s; starting afresh",
                latest_ns.saturating_sub(now_ns) as f64 * 1e-9
            );
            if let Ok(callbacks) = self.on_jump.lock() {
                callbacks.iter().for_each(|forget| forget());
            }
            self.jumps.send_modify(|count| *count += 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_real_jumps_back_count() {
        let clock = Clock::new();
        let jumps = clock.jumps();
        for seconds in [10.0, 10.1, 9.9, 30.0] {
            clock.observe(Time::from_nanos((seconds * 1e9) as i64));
        }
        assert_eq!(*jumps.borrow(), 0);
        clock.observe(Time::from_nanos(11_000_000_000));
        assert_eq!(*jumps.borrow(), 1);
        clock.observe(Time::from_nanos(11_100_000_000));
        assert_eq!(*jumps.borrow(), 1);
    }
}
