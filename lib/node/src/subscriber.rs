//! What a node reads a topic with.

use crate::subscription::Subscription;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::timeout;

/// What a subscriber may expect of its topic.
#[derive(Debug, Clone, Copy)]
pub struct Expect {
    /// Messages kept while the callback is busy; the oldest go first.
    pub queue: usize,
    /// A silence that diagnostics call a trouble; `None` where nobody need publish the topic.
    pub silence_max: Option<Duration>,
}

impl Expect {
    /// State at a high rate, of which only the newest matters.
    pub const STATE: Self = Self {
        queue: 1,
        silence_max: Some(Duration::from_secs(1)),
    };
    /// The same where messages about other things share the topic, as with joint states: in a queue of one they would push
    /// it out.
    pub const SHARED_STATE: Self = Self {
        queue: 8,
        ..Self::STATE
    };
    /// State that need not be there.
    pub const OPTIONAL_STATE: Self = Self {
        silence_max: None,
        ..Self::STATE
    };
    /// Events of which each matters.
    pub const EVENTS: Self = Self {
        queue: 64,
        silence_max: None,
    };
    /// Commands, which are silent while nothing is to be done.
    pub const COMMANDS: Self = Self::EVENTS;
    /// What is published now and then.
    pub const SPORADIC: Self = Self::EVENTS;
}

/// A topic that this node reads, until dropped. Clones share it.
#[derive(Clone)]
pub struct Subscriber {
    subscription: Arc<Open>,
}

struct Open(Arc<Subscription>);

impl Drop for Open {
    fn drop(&mut self) {
        self.0.close();
    }
}

impl Subscriber {
    pub(crate) fn new(subscription: Arc<Subscription>) -> Self {
        let subscription = Arc::new(Open(subscription));
        Self { subscription }
    }

    /// Waits until somebody publishes, so that what is sent from now on arrives; `false` when nobody does in time.
    pub async fn until_connected(&self, patience: Duration) -> bool {
        let mut connected = self.subscription.0.connected();
        let any = connected.wait_for(|count| *count > 0);
        matches!(timeout(patience, any).await, Ok(Ok(_)))
    }

    /// How long nothing has come; `None` if nothing ever has.
    pub fn age(&self) -> Option<Duration> {
        let latest = self.subscription.0.inbox.heard().latest;
        latest.map(|latest| latest.elapsed())
    }
}
