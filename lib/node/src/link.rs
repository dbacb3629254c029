//! What publishers, subscribers and services have in common: somebody looks after them.

use std::net::SocketAddr;
use std::time::Duration;

/// A link that needs looking after.
pub(crate) trait Tended: Send + Sync {
    /// Does what is due. Called a few times a second.
    fn tend(&self);
    /// Told of dialled connections that ended, by their far ends.
    fn lost(&self, _gone: &[SocketAddr]) {}
    /// Registers again with the master.
    fn renew(&self);
    /// Unregisters for good.
    fn close(&self);
    /// What diagnostics should say of it.
    fn report(&self) -> Option<Report> {
        None
    }
}

/// What a subscriber has heard.
#[derive(Debug, Clone)]
pub(crate) struct Report {
    pub topic: String,
    pub count: u64,
    /// Messages that did not come, by the numbers in the headers of those that did.
    pub lost: u64,
    /// Since the last message, or since the node has listened.
    pub silent: Duration,
    /// Silence from which on something is wrong; `None` where silence says nothing.
    pub silence_max: Option<Duration>,
    /// Nodes that publish the topic.
    pub publishers: usize,
}
