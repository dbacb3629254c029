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
    pub age: Option<Duration>,
}
