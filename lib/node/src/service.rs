//! Services that survive a restarted master, and calls that end by their deadline.

use crate::bounded::{BoundedService, Request};
use crate::link::Tended;
use msg::service::Service;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
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

type Offer = Box<dyn Fn() -> rosrust::error::Result<rosrust::Service> + Send + Sync>;

struct Core {
    name: String,
    offer: Offer,
    link: Mutex<Option<rosrust::Service>>,
}

impl Server {
    pub(crate) fn new<S: Service>(
        name: &str,
        handler: impl Fn(S::Request) -> Result<S::Response, String> + Send + Sync + 'static,
    ) -> rosrust::error::Result<Self> {
        let handler = Arc::new(handler);
        let offer: Offer = Box::new({
            let name = name.to_owned();
            move || {
                let handler = Arc::clone(&handler);
                rosrust::service::<BoundedService<S>, _>(&name, move |Request(request)| {
                    handler(request).map(crate::bounded::Response)
                })
            }
        });
        let link = Mutex::new(Some(offer()?));
        Ok(Self {
            core: Arc::new(Core {
                name: name.into(),
                offer,
                link,
            }),
        })
    }

    pub(crate) fn tended(&self) -> Arc<dyn Tended> {
        Arc::clone(&self.core) as Arc<dyn Tended>
    }
}

impl Tended for Core {
    fn tend(&self) {}

    fn renew(&self) {
        let mut link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        *link = None;
        match (self.offer)() {
            Ok(fresh) => *link = Some(fresh),
            Err(error) => log::error!("cannot offer the service {} again: {error}", self.name),
        }
    }

    fn close(&self) {
        *self.link.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Calls the service `name`.
///
/// rosrust's client waits for ever on a server that accepts and never answers. The call runs on a thread of its own,
/// which is left behind at the deadline.
pub(crate) async fn call<S: Service>(
    name: &str,
    request: S::Request,
    deadline: Duration,
) -> Result<S::Response, CallError> {
    let owned = name.to_owned();
    let work = tokio::task::spawn_blocking(move || call_blocking::<S>(&owned, request, deadline));
    match tokio::time::timeout(deadline, work).await {
        Ok(Ok(result)) => result,
        Ok(Err(panic)) => Err(CallError::Failed {
            name: name.into(),
            reason: panic.to_string(),
        }),
        Err(_) => Err(CallError::Deadline {
            name: name.into(),
            deadline,
        }),
    }
}

fn call_blocking<S: Service>(
    name: &str,
    request: S::Request,
    deadline: Duration,
) -> Result<S::Response, CallError> {
    let failed = |reason: String| CallError::Failed {
        name: name.into(),
        reason,
    };
    let start = Instant::now();
    // Half of the time to appear, so that an absent service is told from a slow one.
    rosrust::wait_for_service(name, Some(deadline / 2)).map_err(|_| CallError::Absent {
        name: name.into(),
        waited: start.elapsed(),
    })?;
    let client = rosrust::client::<BoundedService<S>>(name).map_err(|e| failed(e.to_string()))?;
    match client.req(&Request(request)) {
        Ok(Ok(response)) => Ok(response.0),
        Ok(Err(reason)) => Err(failed(reason)),
        Err(error) => Err(failed(error.to_string())),
    }
}
