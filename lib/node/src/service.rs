//! Services that survive a restarted master.

use crate::link::Tended;
use crate::master;
use crate::service_server::{Handler, ServiceServer};
use anyhow::Context;
use msg::service::Service;
use std::sync::{Arc, Mutex, PoisonError};
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
    core: Arc<Core>,
}

struct Core {
    /// With its namespace.
    name: String,
    /// Where callers find it.
    uri: String,
    server: Mutex<Option<ServiceServer>>,
}

impl Server {
    pub(crate) fn new<S: Service>(name: &str, handler: impl Handler<S>) -> anyhow::Result<Self> {
        let name = resolved(name)?;
        let host = rosrust::hostname();
        let server = ServiceServer::start(&name, &host, Arc::new(handler))?;
        let uri = format!("rosrpc://{host}:{}", server.port());
        let core = Core {
            name,
            uri,
            server: Mutex::new(Some(server)),
        };
        master::register_service(&core.name, &core.uri).context("the ROS master")?;
        Ok(Self {
            core: Arc::new(core),
        })
    }

    pub(crate) fn tended(&self) -> Arc<dyn Tended> {
        Arc::clone(&self.core) as Arc<dyn Tended>
    }
}

/// The name with its namespace, and remapped as this process was told.
pub(crate) fn resolved(name: &str) -> anyhow::Result<String> {
    let parameter = rosrust::param(name);
    let parameter = parameter.with_context(|| format!("'{name}' is no name of a service"))?;
    Ok(parameter.name().to_owned())
}

impl Tended for Core {
    fn tend(&self) {}

    fn renew(&self) {
        if let Err(error) = master::register_service(&self.name, &self.uri) {
            log::error!("cannot offer the service {} again: {error}", self.name);
        }
    }

    fn close(&self) {
        let mut server = self.server.lock().unwrap_or_else(PoisonError::into_inner);
        if server.take().is_some()
            && let Err(error) = master::unregister_service(&self.name, &self.uri)
        {
            log::debug!("the service {} stays with the master: {error}", self.name);
        }
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        self.close();
    }
}
