//! A node from start to shutdown.

use crate::caller::Caller;
use crate::clock::Clock;
use crate::environment;
use crate::health::Health;
use crate::parameters::{self, ParameterError};
use crate::publisher::{Latch, Publisher};
use crate::service::{CallError, Server};
use crate::service_client;
use crate::subscriber::{Expect, Subscriber};
use crate::supervisor::{self, Duties, Registry};
use anyhow::Context;
use msg::service::Service;
use rosrust::Message;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// How long a node takes at most to say goodbye to the master.
const FAREWELL: Duration = Duration::from_secs(2);

/// This process as a ROS node. Clones share it; there is one in a process.
#[derive(Clone)]
pub struct Node {
    shared: Arc<Shared>,
}

type Restore = Box<dyn Fn() + Send>;

struct Shared {
    registry: Arc<Registry>,
    clock: Arc<Clock>,
    health: Health,
    shutdown: watch::Sender<bool>,
    /// Writes the parameters in force again.
    restore: Arc<Mutex<Option<Restore>>>,
}

/// Runs a node called `name`: starts it, runs `body` and says goodbye.
///
/// `body` sets up topics and services and then waits for [`Node::until_shutdown`]. When it returns, motion must have
/// stopped: only then are the node's links taken down. An error of it is logged, and the process exits with 1.
pub fn run<F, B>(name: &str, body: B) -> ExitCode
where
    F: Future<Output = anyhow::Result<()>>,
    B: FnOnce(Node) -> F,
{
    crate::memory::share_heap();
    crate::logging::install();
    abort_on_panic();
    let registry = Arc::new(Registry::default());
    let result = runtime().and_then(|runtime| {
        let links = Arc::clone(&registry);
        let result = runtime.block_on(async { body(Node::start(name, links)?).await });
        runtime.shutdown_timeout(Duration::from_millis(100));
        result
    });
    if let Err(error) = &result {
        log::error!("{name}: {error:#}");
    }
    farewell(registry);
    if result.is_ok() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

impl Node {
    fn start(name: &str, registry: Arc<Registry>) -> anyhow::Result<Self> {
        environment::check()?;
        rosrust::try_init_with_options(name, false)
            .map_err(|error| anyhow::anyhow!("cannot register with the ROS master: {error}"))?;
        crate::logging::connect(&rosrust::name());
        let diagnostics = Health::new_publisher().map_err(ros_error)?;
        registry.add(&diagnostics.tended());
        let shared = Arc::new(Shared {
            registry,
            clock: Arc::new(Clock::new()),
            health: Health::new(&rosrust::name(), diagnostics),
            shutdown: watch::Sender::new(false),
            restore: Arc::default(),
        });
        let restore = Arc::clone(&shared.restore);
        supervisor::start(Duties {
            registry: Arc::clone(&shared.registry),
            clock: Arc::clone(&shared.clock),
            health: shared.health.clone(),
            restore: Box::new(move || {
                let restore = restore.lock().unwrap_or_else(PoisonError::into_inner);
                restore.iter().for_each(|restore| restore());
            }),
        })?;
        let node = Self { shared };
        node.watch_signals()?;
        Ok(node)
    }

    fn watch_signals(&self) -> anyhow::Result<()> {
        for kind in [
            SignalKind::interrupt(),
            SignalKind::terminate(),
            SignalKind::hangup(),
        ] {
            let mut stream = signal(kind)?;
            let shared = Arc::clone(&self.shared);
            tokio::spawn(async move {
                if stream.recv().await.is_some() {
                    shared.shutdown.send_replace(true);
                }
            });
        }
        Ok(())
    }

    /// Waits for SIGINT, SIGTERM, SIGHUP or the master's order to shut down.
    pub async fn until_shutdown(&self) {
        let mut shutdown = self.shared.shutdown.subscribe();
        let ordered = async {
            while rosrust::is_ok() {
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        };
        tokio::select! {
            _ = shutdown.wait_for(|down| *down) => {}
            () = ordered => {}
        }
    }

    /// The private parameters, completed with the defaults of `P`.
    ///
    /// `P` must deny unknown fields; `validate` names what is out of range. Both stop the node with a message.
    pub fn parameters<P, E>(
        &self,
        validate: impl Fn(&P) -> Result<(), E>,
    ) -> Result<P, ParameterError>
    where
        P: DeserializeOwned + Serialize + Clone + Send + 'static,
        E: Display,
    {
        let resolved: P = parameters::resolve(&rosrust::name(), parameters::read()?, validate)?;
        self.change_parameters(&resolved);
        Ok(resolved)
    }

    /// Shows on the parameter server what is in force from now on. The node starts with it again when it is respawned.
    pub fn change_parameters<P: Serialize + Clone + Send + 'static>(&self, in_force: &P) {
        parameters::write_back(in_force);
        let again = in_force.clone();
        let mut restore = self
            .shared
            .restore
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        *restore = Some(Box::new(move || parameters::write_back(&again)));
    }

    /// Publishes on `topic`, keeping `queue` messages for slow subscribers.
    pub fn publish<T: Message>(
        &self,
        topic: &str,
        queue: usize,
        latch: Latch,
    ) -> anyhow::Result<Publisher<T>> {
        let publisher = Publisher::new(topic, queue, latch)
            .map_err(ros_error)
            .with_context(|| format!("cannot publish on {topic}"))?;
        self.shared.registry.add(&publisher.tended());
        Ok(publisher)
    }

    /// Calls `callback` with each message on `topic`, one at a time, on a thread of its own.
    pub fn subscribe<T: Message>(
        &self,
        topic: &str,
        expect: Expect,
        callback: impl Fn(T) + Send + Sync + 'static,
    ) -> anyhow::Result<Subscriber> {
        let subscriber = Subscriber::new(topic, expect, callback)
            .map_err(ros_error)
            .with_context(|| format!("cannot subscribe to {topic}"))?;
        self.shared.registry.add(&subscriber.tended());
        Ok(subscriber)
    }

    /// Offers the service `name`. `handler` runs on a thread for each call, several at once if called so.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        handler: impl Fn(S::Request) -> Result<S::Response, String> + Send + Sync + 'static,
    ) -> anyhow::Result<Server> {
        self.serve_caller::<S>(name, move |request, _| handler(request))
    }

    /// As [`Node::serve`]; `handler` is also told who waits for the answer, so that it can give up when nobody does.
    pub fn serve_caller<S: Service>(
        &self,
        name: &str,
        handler: impl Fn(S::Request, Caller) -> Result<S::Response, String> + Send + Sync + 'static,
    ) -> anyhow::Result<Server> {
        let server = Server::new::<S>(name, Arc::new(handler))
            .with_context(|| format!("cannot offer the service {name}"))?;
        self.shared.registry.add(&server.tended());
        Ok(server)
    }

    /// Calls the service `name` and waits for the answer until `deadline` has passed. Dropped before, it hangs up, and the
    /// service knows that nobody waits.
    pub async fn call<S: Service>(
        &self,
        name: &str,
        request: S::Request,
        deadline: Duration,
    ) -> Result<S::Response, CallError> {
        service_client::call::<S>(name, request, deadline).await
    }

    /// Name of this node, with its namespace.
    pub fn name(&self) -> String {
        rosrust::name()
    }

    /// Names of the nodes that publish on `topic` (with its namespace), as the master has them.
    pub fn publishers_of(&self, topic: &str) -> anyhow::Result<Vec<String>> {
        environment::check_master().context("no word from the ROS master")?;
        let state = rosrust::state()
            .map_err(|error| anyhow::anyhow!("no word from the ROS master: {error}"))?;
        let found = state
            .publishers
            .into_iter()
            .find(|entry| entry.name == topic);
        Ok(found.map(|entry| entry.connections).unwrap_or_default())
    }

    /// ROS time.
    pub fn clock(&self) -> Arc<Clock> {
        Arc::clone(&self.shared.clock)
    }

    /// What diagnostics say of this node.
    pub fn health(&self) -> Health {
        self.shared.health.clone()
    }
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("cannot start the runtime")
}

/// rosrust runs each callback on a thread that a panic would end silently, leaving a node that hears nothing. A process
/// that is gone is started again by roslaunch.
fn abort_on_panic() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        report(info);
        std::process::abort();
    }));
}

/// Unregisters, but does not wait for a master that is out of reach.
fn farewell(registry: Arc<Registry>) {
    if !rosrust::is_initialized() {
        return;
    }
    let (done, wait) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        registry.close();
        rosrust::shutdown();
        done.send(())
    });
    if wait.recv_timeout(FAREWELL).is_err() {
        eprintln!("the ROS master does not answer; leaving without unregistering");
    }
}

/// rosrust's errors are chains that anyhow cannot hold, since they are not `Sync`.
fn ros_error(error: rosrust::error::Error) -> anyhow::Error {
    anyhow::anyhow!("{error}")
}
