//! The end of the process: who is told of it, and who is waited for.

use std::sync::LazyLock;
use std::time::Duration;
use tokio::sync::watch;
use tokio::time::Instant;

/// How long a node takes at most from the order to end to its exit.
pub(crate) const SHUTDOWN_MAX: Duration = Duration::from_secs(3);

/// When the process was told to end. There is one node in a process.
static ORDERED: LazyLock<watch::Sender<Option<Instant>>> =
    LazyLock::new(|| watch::Sender::new(None));

/// How many pieces of work are under way.
static UNDER_WAY: LazyLock<watch::Sender<usize>> = LazyLock::new(|| watch::Sender::new(0));

/// Tells everybody to end; the first order counts.
pub(crate) fn order() {
    ORDERED.send_if_modified(|ordered| {
        let is_first = ordered.is_none();
        ordered.get_or_insert_with(Instant::now);
        is_first
    });
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

/// A piece of work that the end of the process waits for, until dropped.
pub(crate) struct Work(());

impl Work {
    pub fn begin() -> Self {
        UNDER_WAY.send_modify(|count| *count += 1);
        Self(())
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        UNDER_WAY.send_modify(|count| *count -= 1);
    }
}

/// Waits until no work is under way; `false` where `deadline` comes first.
pub(crate) async fn all_work_ended(deadline: Instant) -> bool {
    let mut under_way = UNDER_WAY.subscribe();
    let ended = under_way.wait_for(|count| *count == 0);
    tokio::time::timeout_at(deadline, ended).await.is_ok()
}
