//! A count that another node publishes, latched, and that says by each change that something has happened.

use crate::node::Node;
use crate::subscriber::Subscriber;
use crate::subscription::Expect;
use msg::std_msgs::UInt64;
use tokio::sync::watch;

/// The newest value of a count. Clones share it.
#[derive(Clone)]
pub struct Count {
    newest: watch::Receiver<Option<u64>>,
    _subscriber: Subscriber,
}

impl Node {
    /// Follows the count on `topic` from now on.
    ///
    /// # Errors
    /// Where the name is none.
    pub fn follow_count(&self, topic: &str) -> anyhow::Result<Count> {
        let (sender, newest) = watch::channel(None);
        let note = move |count: UInt64| note(&sender, count.data);
        let subscriber = self.subscribe(topic, Expect::EVENTS, note)?;
        Ok(Count {
            newest,
            _subscriber: subscriber,
        })
    }
}

impl Count {
    /// Returns when the count changes after this call. A count that is heard for the first time has not changed.
    pub fn until_changed(&self) -> impl Future<Output = ()> + Send + use<> {
        let mut newest = self.newest.clone();
        newest.mark_unchanged();
        async move {
            if newest.changed().await.is_err() {
                // Nobody writes it any more: the subscriber went with the node.
                std::future::pending().await
            }
        }
    }
}

/// Only a change of a known count wakes who waits.
fn note(newest: &watch::Sender<Option<u64>>, count: u64) {
    newest.send_if_modified(|newest| {
        let before = newest.replace(count);
        before.is_some_and(|before| before != count)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_and_a_repeated_one_are_no_change() {
        let (sender, newest) = watch::channel(None);
        for (count, is_change) in [(3, false), (3, false), (4, true), (0, true)] {
            let mut before = newest.clone();
            before.mark_unchanged();
            note(&sender, count);
            assert_eq!(before.has_changed().ok(), Some(is_change), "{count}");
        }
    }
}
