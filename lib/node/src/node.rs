//! A node from start to shutdown.

use crate::clock::Clock;
use crate::environment;
use crate::health::Health;
use crate::life::Life;
use crate::parameters::{self, ParameterError};
use crate::publisher::{Latch, Publisher};
use crate::service::{CallError, Server};
use crate::service_client;
use crate::service_server::Handler;
use crate::shutdown::{self, SHUTDOWN_MAX};
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
use tokio::time::Instant;

/// How long the master has at most to hear that a node goes.
const FAREWELL: Duration = Duration::from_secs(1);

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
    /// Writes the parameters in force again.
    restore: Arc<Mutex<Option<Restore>>>,
}

/// Runs a node called `name`: starts it, runs `body` and ends it.
///
/// `body` sets up topics and services and then waits for [`Node::until_shutdown`], upon which each [`Life`] ends. It returns
/// once nothing moves any more. Then the requests under way are answered, and only after that the node's links are taken
/// down. All of it takes 3 s at most. An error of `body` is logged, and the process exits with 1.
pub fn run<F, B>(name: &str, body: B) -> ExitCode
where
    F: Future<Output = anyhow::Result<()>>,
    B: FnOnce(Node) -> F,
{
    run_for(name, Some(SHUTDOWN_MAX - FAREWELL), body)
}

/// As [`run`], for a program of the terminal: its `body` ends when it has told its user all, however long that takes.
pub fn run_program<F, B>(name: &str, body: B) -> ExitCode
where
    F: Future<Output = anyhow::Result<()>>,
    B: FnOnce(Node) -> F,
{
    run_for(name, None, body)
}

fn run_for<F, B>(name: &str, rest_max: Option<Duration>, body: B) -> ExitCode
where
    F: Future<Output = anyhow::Result<()>>,
    B: FnOnce(Node) -> F,
{
    crate::memory::share_heap();
    crate::logging::install();
    abort_on_panic();
    let registry = Arc::new(Registry::default());
    let links = Arc::clone(&registry);
    let result = runtime().and_then(|runtime| {
        let result = runtime.block_on(async {
            let result = match Node::start(name, links) {
                Ok(node) => run_body(body(node), rest_max).await,
                Err(error) => Err(error),
            };
            end_requests(name).await;
            result
        });
        if let Err(error) = &result {
            log::error!("{name}: {error:#}");
        }
        farewell(registry);
        runtime.shutdown_timeout(Duration::from_millis(100));
        result
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// Until it returns, or has not done so `rest_max` after it was told to end.
async fn run_body(
    body: impl Future<Output = anyhow::Result<()>>,
    rest_max: Option<Duration>,
) -> anyhow::Result<()> {
    let late = async {
        let ordered = shutdown::ordered().await;
        match rest_max {
            Some(rest_max) => tokio::time::sleep_until(ordered + rest_max).await,
            None => std::future::pending().await,
        }
    };
    tokio::select! {
        result = body => result,
        () = late => Err(anyhow::anyhow!("did not come to rest in time")),
    }
}

/// Ends each [`Life`], and waits until all requests are answered.
async fn end_requests(name: &str) {
    shutdown::order();
    let deadline = shutdown::ordered().await + SHUTDOWN_MAX - FAREWELL;
    // A body that ended by itself leaves work that was told just now.
    let deadline = deadline.max(Instant::now() + Duration::from_millis(500));
    if !shutdown::all_work_ended(deadline).await {
        log::error!("{name}: ended before all requests were answered");
    }
}

/// Runs what computes for long beside the node's other work.
///
/// # Errors
/// Where the node ends meanwhile.
pub async fn compute<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|_| "the node is shutting down".to_owned())
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
            tokio::spawn(async move {
                if stream.recv().await.is_some() {
                    shutdown::order();
                }
            });
        }
        tokio::spawn(async {
            // rosrust tells nobody when the master orders it.
            while rosrust::is_ok() {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
            shutdown::order();
        });
        Ok(())
    }

    /// Waits for SIGINT, SIGTERM, SIGHUP or the master's order to shut down.
    pub async fn until_shutdown(&self) {
        shutdown::ordered().await;
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

    /// Offers the service `name`. `handler` answers each request, several at once if called so; its [`Life`] ends when the
    /// caller has gone or this node is told to end. What it moved must rest when it answers. What computes for long belongs
    /// into [`compute`].
    ///
    /// # Errors
    /// Where the name is none, or the master cannot be reached.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        handler: impl Handler<S>,
    ) -> anyhow::Result<Server> {
        let server = Server::new::<S>(name, handler)
            .with_context(|| format!("cannot offer the service {name}"))?;
        self.shared.registry.add(&server.tended());
        Ok(server)
    }

    /// Calls the service `name` and waits for the answer until `deadline` has passed or `life` has ended. Then it hangs up,
    /// which the service's handler is told, and waits up to 1.5 s more for what moves to rest. Dropped, it hangs up at once.
    ///
    /// # Errors
    /// Says why there is no answer.
    pub async fn call<S: Service>(
        &self,
        name: &str,
        request: S::Request,
        deadline: Duration,
        life: &Life,
    ) -> Result<S::Response, CallError> {
        service_client::call::<S>(name, request, deadline, life).await
    }

    /// Lives until this node is told to end: for what nobody outside asked for. Must be called in the runtime.
    pub fn life(&self) -> Life {
        Life::until(std::future::pending())
    }

    /// Name of this node, with its namespace.
    pub fn name(&self) -> String {
        rosrust::name()
    }

    /// A topic's or service's name with its namespace, as it is remapped; as it is given where it is none.
    pub fn resolved(&self, name: &str) -> String {
        let parameter = rosrust::param(name);
        parameter.map_or_else(|| name.to_owned(), |parameter| parameter.name().to_owned())
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
