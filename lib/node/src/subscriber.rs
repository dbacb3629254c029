//! What a node reads a topic with.

use crate::subscription::Subscription;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::timeout;

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
}
