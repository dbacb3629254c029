//! What a node publishes a topic with.

use crate::publication::Publication;
use crate::{clock, names};
use rosrust::{Clock, Message, Time};
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;
use tokio::time::{Instant, timeout, timeout_at};

/// How long a topic may be without listeners before nobody is said to wait for it.
const UNHEARD_MAX: Duration = Duration::from_secs(3);

/// A topic that this node publishes. Clones share it.
pub struct Publisher<T: Message> {
    name: Arc<str>,
    publication: Arc<Publication>,
    /// Numbers the messages that have a header.
    numbers: Arc<AtomicUsize>,
    message: PhantomData<fn(T)>,
}

impl<T: Message> Clone for Publisher<T> {
    fn clone(&self) -> Self {
        Self {
            name: Arc::clone(&self.name),
            publication: Arc::clone(&self.publication),
            numbers: Arc::clone(&self.numbers),
            message: PhantomData,
        }
    }
}

impl<T: Message> Publisher<T> {
    pub(crate) fn new(name: &str, publication: Arc<Publication>) -> Self {
        Self {
            name: name.into(),
            publication,
            numbers: Arc::default(),
            message: PhantomData,
        }
    }

    /// Name of the topic, as it was given.
    pub fn topic(&self) -> &str {
        &self.name
    }

    /// Queues `message` for all subscribers. A header without stamp or number gets them.
    pub fn send(&self, mut message: T) {
        if !self.publication.is_wanted() {
            return;
        }
        let clock: Arc<dyn Clock> = Arc::new(Stamps);
        message.set_header(&clock, &self.numbers);
        match message.encode_vec() {
            Ok(bytes) => self.publication.send(bytes.into()),
            Err(error) => log::error!("cannot publish on {}: {error}", self.name),
        }
    }

    /// Whether anybody listens.
    pub fn is_subscribed(&self) -> bool {
        self.publication.is_subscribed()
    }

    /// Names of the nodes that listen now, this one included where it does. A node that died is missing at once; one whose
    /// computer was unplugged, within 3 s on a topic of [`Node::publish_prompt`](crate::Node::publish_prompt), on others within
    /// a minute.
    pub fn subscribers(&self) -> Vec<String> {
        self.publication.subscribers()
    }

    /// Waits until somebody listens, so that what is sent next is not lost; `false` when nobody does in time.
    pub async fn until_subscribed(&self, patience: Duration) -> bool {
        let subscribed = async {
            let mut changes = self.publication.changes();
            while !self.is_subscribed() && changes.changed().await.is_ok() {}
        };
        timeout(patience, subscribed).await.is_ok()
    }

    /// Waits until no other node has listened for 3 s, as with the callers of services: nobody waits any more. Meant for topics
    /// of [`Node::publish_prompt`](crate::Node::publish_prompt), where a computer that says nothing for 3 s is enough.
    pub async fn until_unheard(&self) {
        let mut changes = self.publication.changes();
        let is_other = |name: &String| name != names::own();
        let mut deadline = Instant::now() + UNHEARD_MAX;
        loop {
            if self.subscribers().iter().any(is_other) {
                // The sender lives as long as the publication.
                let _ = changes.changed().await;
                let was_silent = self.publication.is_last_unreachable();
                let patience = if was_silent {
                    Duration::ZERO
                } else {
                    UNHEARD_MAX
                };
                deadline = Instant::now() + patience;
            } else if timeout_at(deadline, changes.changed()).await.is_err() {
                return;
            }
        }
    }
}

/// ROS time for rosrust, which stamps messages but is asked for nothing else.
struct Stamps;

impl Clock for Stamps {
    fn now(&self) -> Time {
        clock::now()
    }
    fn sleep(&self, _: rosrust::Duration) {}
    fn wait_until(&self, _: Time) {}
}
