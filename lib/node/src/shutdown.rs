//! Shutdown of the process: the order to end, and the counters of what it waits for.

use std::io;
use std::sync::LazyLock;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::time::Instant;

/// When the process was told to end. There is one node in a process.
static ORDERED: LazyLock<watch::Sender<Option<Instant>>> =
    LazyLock::new(|| watch::Sender::new(None));

/// Number of service requests and computations that are under way.
pub(crate) static REQUESTS: Running = Running::new();
/// Number of threads that call back with messages.
pub(crate) static THREADS: Running = Running::new();

/// Orders the shutdown; later orders have no effect.
pub(crate) fn order() {
    ORDERED.send_if_modified(|ordered| {
        let is_first = ordered.is_none();
        ordered.get_or_insert_with(Instant::now);
        is_first
    });
}

/// Installs handlers: SIGINT, SIGTERM and SIGHUP order the shutdown.
///
/// # Errors
/// A handler cannot be installed.
pub(crate) fn order_on_signals() -> io::Result<()> {
    for kind in [
        SignalKind::interrupt(),
        SignalKind::terminate(),
        SignalKind::hangup(),
    ] {
        let mut stream = signal(kind)?;
        tokio::spawn(async move {
            if stream.recv().await.is_some() {
                order();
            }
        });
    }
    Ok(())
}

/// Whether the process was told to end.
pub(crate) fn is_ordered() -> bool {
    ORDERED.borrow().is_some()
}

/// Waits until the process is told to end; returns when that was.
pub(crate) async fn ordered() -> Instant {
    let mut ordered = ORDERED.subscribe();
    loop {
        if let Some(when) = *ordered.borrow_and_update() {
            return when;
        }
        // The sender is static and never closed.
        let _ = ordered.changed().await;
    }
}

/// A counter that the shutdown waits for.
pub(crate) struct Running(LazyLock<watch::Sender<usize>>);

/// Counts one, until dropped.
pub(crate) struct Counted(&'static Running);

impl Running {
    const fn new() -> Self {
        Self(LazyLock::new(|| watch::Sender::new(0)))
    }

    pub fn begin(&'static self) -> Counted {
        self.0.send_modify(|count| *count += 1);
        Counted(self)
    }

    /// Waits until the counter is zero; `false` where `deadline` comes first.
    pub async fn all_ended(&self, deadline: Instant) -> bool {
        let mut count = self.0.subscribe();
        let ended = count.wait_for(|count| *count == 0);
        tokio::time::timeout_at(deadline, ended).await.is_ok()
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0
            .0
            .send_modify(|count| *count = count.saturating_sub(1));
    }
}
