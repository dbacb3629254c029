//! A node from start to shutdown.

use crate::bounded;
use crate::clock::{self, Clock};
use crate::graph::Graph;
use crate::health::Health;
use crate::inbox::Inbox;
use crate::life::Life;
use crate::message_kind::MessageKind;
use crate::parameters::{self, ParameterError};
use crate::publication::{Latch, Publication};
use crate::publisher::Publisher;
use crate::service_client::CallError;
use crate::service_server::{Handler, Server};
use crate::shutdown::{self, REQUESTS};
use crate::subscriber::Subscriber;
use crate::subscription::{Expect, Subscription};
use crate::tcpros::{PATIENT, PROMPT};
use crate::xmlrpc::Value;
use crate::{environment, master, names, service_client};
use anyhow::Context;
use msg::service::Service;
use msg::{Message, Time, rosgraph_msgs};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Display;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

const REPORT_PERIOD: Duration = Duration::from_secs(1);
/// How often it is looked whether ROS time went back.
const CLOCK_PERIOD: Duration = Duration::from_millis(20);

/// This process as a ROS node. Clones share it; there is one in a process.
#[derive(Clone)]
pub struct Node {
    shared: Arc<Shared>,
}

struct Shared {
    graph: Arc<Graph>,
    clock: Arc<Clock>,
    health: Health,
}

impl Node {
    /// Joins the graph under `name`, or as the arguments say.
    pub(crate) async fn start(name: &str) -> anyhow::Result<Self> {
        names::set(name)?;
        let graph = Graph::start(environment::check().await?)?;
        let clock = Arc::new(Clock::new());
        let diagnostics = publish_on(&graph, "/diagnostics", 10, Latch::No, PATIENT)?;
        crate::logging::connect(publish_on(&graph, "/rosout", 100, Latch::No, PATIENT)?);
        let health = Health::new(names::own(), diagnostics);
        let shared = Arc::new(Shared {
            graph,
            clock,
            health,
        });
        let node = Self { shared };
        node.follow_clock().await?;
        shutdown::order_on_signals()?;
        tokio::spawn(node.clone().report());
        Ok(node)
    }

    /// Takes time from /clock where the parameter server says so, and watches for jumps.
    async fn follow_clock(&self) -> anyhow::Result<()> {
        let name = "/use_sim_time".into();
        if let Ok(Value::Bool(true)) = master::call("getParam", &[name]).await {
            clock::simulate(Time::default());
            let set = |now: rosgraph_msgs::Clock| clock::simulate(now.clock);
            let ticks = self.subscribe("/clock", Expect::OPTIONAL_STATE, set)?;
            // As long as the node.
            std::mem::forget(ticks);
        }
        let clock = self.clock();
        tokio::spawn(async move {
            let mut ticker = interval(CLOCK_PERIOD);
            ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
            loop {
                ticker.tick().await;
                clock.observe(clock.now());
            }
        });
        Ok(())
    }

    async fn report(self) {
        let mut ticker = interval(REPORT_PERIOD);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            ticker.tick().await;
            let read = self.shared.graph.subscriptions();
            let reports = read.iter().map(|subscription| subscription.report());
            self.shared.health.publish(reports.collect());
        }
    }

    /// This process in the graph.
    pub(crate) fn graph(&self) -> &Arc<Graph> {
        &self.shared.graph
    }

    /// Waits for SIGINT, SIGTERM, SIGHUP or the master's order to shut down.
    pub async fn until_shutdown(&self) {
        shutdown::ordered().await;
    }

    /// The private parameters, completed with the defaults of `P`.
    ///
    /// `P` must deny unknown fields; `validate` names what is out of range. Both stop the node with a message.
    ///
    /// # Errors
    /// A parameter is unknown, has another type, or is refused by `validate`; or the master cannot be asked.
    pub fn parameters<P, E>(
        &self,
        validate: impl Fn(&P) -> Result<(), E>,
    ) -> Result<P, ParameterError>
    where
        P: DeserializeOwned + Serialize + Clone + Send + 'static,
        E: Display,
    {
        let resolved: P = parameters::resolve(names::own(), parameters::read()?, validate)?;
        self.change_parameters(&resolved);
        Ok(resolved)
    }

    /// Shows on the parameter server what is in force from now on. The node starts with it again when it is respawned.
    pub fn change_parameters<P: Serialize + Clone + Send + 'static>(&self, in_force: &P) {
        parameters::write_back(in_force);
        let again = in_force.clone();
        let restore = move || parameters::write_back(&again);
        self.shared.graph.registrations.on_restart(restore);
    }

    /// Publishes on `topic`, keeping `queue` messages for slow subscribers.
    ///
    /// # Errors
    /// The name is invalid, or this node publishes the topic already.
    pub fn publish<T: Message>(
        &self,
        topic: &str,
        queue: usize,
        latch: Latch,
    ) -> anyhow::Result<Publisher<T>> {
        publish_on(&self.shared.graph, topic, queue, latch, PATIENT)
    }

    /// The same without latch, for what must not arrive late, such as commands, or where it matters who listens: a subscriber
    /// whose computer says nothing for 3 s is put out, and what was on the way to it is lost.
    ///
    /// # Errors
    /// Where the name is none, or this node publishes the topic already.
    pub fn publish_prompt<T: Message>(
        &self,
        topic: &str,
        queue: usize,
    ) -> anyhow::Result<Publisher<T>> {
        publish_on(&self.shared.graph, topic, queue, Latch::No, PROMPT)
    }

    /// Calls `callback` with each message on `topic`, one at a time, on a thread of its own.
    ///
    /// # Errors
    /// The name is invalid, or the topic cannot be registered.
    pub fn subscribe<T: Message>(
        &self,
        topic: &str,
        expect: Expect,
        callback: impl Fn(T) + Send + Sync + 'static,
    ) -> anyhow::Result<Subscriber> {
        let read = move |mut bytes: Vec<u8>, note: &dyn Fn(Option<u32>)| {
            let (message, number) = bounded::message::<T>(&mut bytes)?;
            note(number);
            callback(message);
            Ok(())
        };
        let resolved = names::resolve(topic)?;
        let inbox = Inbox::start(topic, expect.queue, read)
            .with_context(|| format!("cannot subscribe to {topic}"))?;
        let kind = MessageKind::of::<T>();
        let subscription = Arc::new(Subscription::new(topic, resolved, kind, expect, inbox));
        self.shared.graph.subscribe(&subscription);
        Ok(Subscriber::new(subscription))
    }

    /// Offers the service `name`. `handler` answers each request, several at once if called so; its [`Life`] ends when the
    /// caller has gone or this node is told to end. What it moved must rest when it answers. What computes for long belongs
    /// into [`compute`].
    ///
    /// # Errors
    /// Where the name is none, or no port can be had.
    pub fn serve<S: Service>(
        &self,
        name: &str,
        handler: impl Handler<S>,
    ) -> anyhow::Result<Server> {
        names::resolve(name)
            .and_then(|resolved| Ok(self.shared.graph.serve(resolved, handler)?))
            .with_context(|| format!("cannot offer the service {name}"))
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
        names::own().into()
    }

    /// A topic's or service's name with its namespace, as it is remapped; as it is given where it is none.
    pub fn resolved(&self, name: &str) -> String {
        names::resolve(name).unwrap_or_else(|_| name.to_owned())
    }

    /// Names of the nodes that publish on `topic` (with its namespace), as the master has them; waits for its answer.
    ///
    /// # Errors
    /// Where the master does not answer.
    pub fn publishers_of(&self, topic: &str) -> anyhow::Result<Vec<String>> {
        let topics = master::blocking(master::topics());
        let [mut published, _] = topics.context("no word from the ROS master")?;
        Ok(published.remove(topic).unwrap_or_default())
    }

    /// Whether somebody offers the service `name`, as the master has it; waits for its answer.
    ///
    /// # Errors
    /// Where the name is none.
    pub fn is_served(&self, name: &str) -> anyhow::Result<bool> {
        let name = names::resolve(name)?;
        Ok(master::blocking(master::lookup_service(&name)).is_some())
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

fn publish_on<T: Message>(
    graph: &Graph,
    topic: &str,
    queue: usize,
    latch: Latch,
    silence_max: Duration,
) -> anyhow::Result<Publisher<T>> {
    let resolved = names::resolve(topic)?;
    let kind = MessageKind::of::<T>();
    let publication = Publication::new(resolved, kind, queue, latch, silence_max);
    let publication = graph.publish(publication)?;
    Ok(Publisher::new(topic, publication))
}

/// Runs what computes for long beside the node's other work.
///
/// # Errors
/// Where the node ends meanwhile.
pub async fn compute<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    // The end of the process waits for it: libraries do not like to be in use then.
    let counted = REQUESTS.begin();
    let done = tokio::task::spawn_blocking(move || (work(), counted)).await;
    done.map(|(result, _)| result)
        .map_err(|_| "the node is shutting down".to_owned())
}
