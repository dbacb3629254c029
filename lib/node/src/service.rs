//! What a node offers a service with, and why a call of one may fail.

use crate::graph::Graph;
use crate::names;
use crate::registration::Entry;
use crate::service_server::{Handler, ServiceServer};
use msg::service::Service;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// Why a service call gave no answer.
#[derive(Debug, Error, PartialEq)]
pub enum CallError {
    /// Nobody offers the service.
    #[error("nobody offers the service {name} (waited {waited:.1?}); is its node running?")]
    Absent {
        /// Name of the service.
        name: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// No answer in time.
    #[error("the service {name} did not answer within {deadline:.1?}")]
    Deadline {
        /// Name of the service.
        name: String,
        /// The time it had.
        deadline: Duration,
    },
    /// Whoever waited for the answer has gone, or this node ends.
    #[error("the service {name} was given up: {reason}")]
    GivenUp {
        /// Name of the service.
        name: String,
        /// Why nobody waits any more.
        reason: String,
    },
    /// The server or the connection failed.
    #[error("the service {name} failed: {reason}")]
    Failed {
        /// Name of the service.
        name: String,
        /// What it said.
        reason: String,
    },
}

/// A service that this node offers, until dropped.
pub struct Server {
    _server: ServiceServer,
}

impl Server {
    pub(crate) fn new<S: Service>(
        graph: &Graph,
        name: &str,
        handler: impl Handler<S>,
    ) -> anyhow::Result<Self> {
        let name = names::resolve(name)?;
        let server = ServiceServer::start(&name, &graph.host, Arc::new(handler))?;
        let uri = format!("rosrpc://{}:{}", graph.host, server.port());
        graph.registrations.add(Entry::Service { name, uri });
        Ok(Self { _server: server })
    }
}
