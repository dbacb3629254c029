//! What the watch over the other nodes reports.

use crate::clock_skew::ClockOffset;
use std::fmt;

/// The origin of a stamp.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// The node of this name.
    Node(String),
    /// The only publisher of this topic, whose name need not be known.
    Topic(String),
}

/// A node that does not answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Unreachable {
    /// Name of the node.
    pub node: String,
    /// Where the master says that it is; empty where it does not say.
    pub host: String,
    /// The error of the last attempt to reach it.
    pub reason: String,
}

/// The clock of the computer that a node runs on.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerClock {
    /// Origin of the stamps that the offset was estimated from.
    pub source: Source,
    /// Name of the node.
    pub node: String,
    /// Its computer's name or address, where known.
    pub host: String,
    /// How far its clock is from ours.
    pub offset: ClockOffset,
}

impl PeerClock {
    /// Whether it is ahead of this computer's.
    pub fn is_ahead(&self) -> bool {
        self.offset.offset_s > 0.0
    }
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { node, host, reason } = self;
        match &host[..] {
            "" => write!(f, "{node} does not answer ({reason})"),
            _ => write!(f, "{node} at {host} does not answer ({reason})"),
        }
    }
}

impl fmt::Display for PeerClock {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            node, host, offset, ..
        } = self;
        let sense = if offset.offset_s < 0.0 {
            "behind"
        } else {
            "ahead of"
        };
        let at = if host.is_empty() {
            String::new()
        } else {
            format!(" at {host}")
        };
        write!(
            f,
            "the clock of {node}{at} is {:.0} ms {sense} this computer's (± {:.0} ms)",
            offset.offset_s.abs() * 1e3,
            offset.uncertainty_s * 1e3
        )
    }
}
