//! Publishers that survive a restarted master, and whose latched messages also reach those who cannot know of latching.

use crate::link::Tended;
use crate::listeners;
use crate::service::resolved;
use rosrust::Message;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::{Duration, Instant};

/// rosrust does not tell subscribers that a topic is latched, so that rosbag records it once and replays it never again.
const REPEAT: Duration = Duration::from_secs(1);
/// Pause between looks for a listener; rosrust tells nobody when one comes.
const LISTENER_PERIOD: Duration = Duration::from_millis(20);
/// How long a topic may be without listeners before nobody is said to wait for it, as with the callers of services.
const UNHEARD_MAX: Duration = Duration::from_secs(3);
/// Pause between looks whether somebody still listens.
const UNHEARD_PERIOD: Duration = Duration::from_millis(250);

/// Whether late subscribers get the last message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Latch {
    /// They wait for the next one.
    No,
    /// They get it at once, and everybody again each second: receivers must know repeated messages by their content.
    Yes,
}

/// A topic that this node publishes. Clones share it.
#[derive(Clone)]
pub struct Publisher<T: Message> {
    core: Arc<Core<T>>,
}

struct Core<T: Message> {
    topic: String,
    queue: usize,
    latch: Latch,
    link: RwLock<Option<rosrust::Publisher<T>>>,
    last: Mutex<Option<(T, Instant)>>,
}

impl<T: Message> Publisher<T> {
    pub(crate) fn new(topic: &str, queue: usize, latch: Latch) -> rosrust::error::Result<Self> {
        let core = Core {
            topic: topic.into(),
            queue,
            latch,
            link: RwLock::new(None),
            last: Mutex::new(None),
        };
        core.connect()?;
        Ok(Self {
            core: Arc::new(core),
        })
    }

    pub(crate) fn tended(&self) -> Arc<dyn Tended> {
        Arc::clone(&self.core) as Arc<dyn Tended>
    }

    /// Name of the topic.
    pub fn topic(&self) -> &str {
        &self.core.topic
    }

    /// Queues `message` for all subscribers.
    pub fn send(&self, message: T) {
        if self.core.latch == Latch::Yes {
            let mut last = self
                .core
                .last
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            *last = Some((message.clone(), Instant::now()));
        }
        self.core.send(message);
    }

    /// Whether anybody listens. A subscriber that vanished counts until the next message to it fails.
    pub fn is_subscribed(&self) -> bool {
        self.core.is_subscribed()
    }

    /// Waits until nobody has listened for 3 s; who died or cannot be reached any more does not count.
    pub async fn until_unheard(&self) {
        let mut heard = tokio::time::Instant::now();
        while heard.elapsed() < UNHEARD_MAX {
            let topic = self.core.topic.clone();
            let count = tokio::task::spawn_blocking(move || {
                let topic = resolved(&topic).map_err(std::io::Error::other)?;
                listeners::count(&topic)
            });
            if matches!(count.await, Ok(Ok(1..))) {
                heard = tokio::time::Instant::now();
            }
            tokio::time::sleep(UNHEARD_PERIOD).await;
        }
    }

    /// Waits until somebody listens, so that what is sent next is not lost; `false` when nobody does in time.
    pub async fn until_subscribed(&self, patience: Duration) -> bool {
        let deadline = Instant::now() + patience;
        while !self.is_subscribed() {
            if Instant::now() >= deadline {
                return false;
            }
            tokio::time::sleep(LISTENER_PERIOD).await;
        }
        true
    }
}

impl<T: Message> Core<T> {
    fn connect(&self) -> rosrust::error::Result<()> {
        let mut link = self.link.write().unwrap_or_else(PoisonError::into_inner);
        // The old handle must be gone first: its end unregisters the topic, whoever else holds it.
        *link = None;
        let mut fresh = rosrust::publish(&self.topic, self.queue)?;
        fresh.set_latching(self.latch == Latch::Yes);
        *link = Some(fresh);
        Ok(())
    }

    fn send(&self, message: T) {
        let link = self.link.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(error)) = link.as_ref().map(|link| link.send(message)) {
            log::error!("cannot publish on {}: {error}", self.topic);
        }
    }

    fn is_subscribed(&self) -> bool {
        let link = self.link.read().unwrap_or_else(PoisonError::into_inner);
        link.as_ref()
            .is_some_and(|link| link.subscriber_count() > 0)
    }
}

impl<T: Message> Tended for Core<T> {
    fn tend(&self) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((message, sent)) = last.as_mut() else {
            return;
        };
        if sent.elapsed() >= REPEAT && self.is_subscribed() {
            *sent = Instant::now();
            self.send(message.clone());
        }
    }

    fn renew(&self) {
        if let Err(error) = self.connect() {
            log::error!(
                "cannot register the publisher of {} again: {error}",
                self.topic
            );
        }
    }

    fn close(&self) {
        *self.link.write().unwrap_or_else(PoisonError::into_inner) = None;
    }
}
