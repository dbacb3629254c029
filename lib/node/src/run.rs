//! A node's process from start to end.

use crate::graph::Graph;
use crate::node::Node;
use crate::shutdown::{self, REQUESTS, THREADS};
use anyhow::Context;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::{Instant, sleep_until};

/// How long a node's body has to bring to rest what moves, and its requests to be answered.
const REST_MAX: Duration = Duration::from_secs(2);
/// The same for the requests where the body has ended by itself, or takes its time.
const ANSWER_MIN: Duration = Duration::from_millis(500);
/// How long what was published, and the callbacks, have to be done.
const FLUSH_MAX: Duration = Duration::from_millis(300);
/// How long the master has to hear that the node goes.
const FAREWELL_MAX: Duration = Duration::from_millis(500);

/// Runs a node called `name`: starts it, runs `body` and ends it.
///
/// `body` sets up topics and services and then waits for [`Node::until_shutdown`], upon which each
/// [`Life`](crate::Life) ends. It returns once nothing moves any more. Then the requests under way are answered, what was
/// published is sent, and only after that the node leaves the graph. All of it takes 3 s at most. An error of `body` is
/// logged, and the process exits with 1.
pub fn run<F, B>(name: &str, body: B) -> ExitCode
where
    F: Future<Output = anyhow::Result<()>>,
    B: FnOnce(Node) -> F,
{
    run_for(name, Some(REST_MAX), body)
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
    let result = runtime().and_then(|runtime| {
        let result = runtime.block_on(async {
            let node = Node::start(name)
                .await
                .inspect_err(|error| log::error!("{name}: {error:#}"))?;
            let graph = Arc::clone(node.graph());
            let result = until_rest(body(node), rest_max).await;
            if let Err(error) = &result {
                log::error!("{name}: {error:#}");
            }
            leave(name, &graph).await;
            result
        });
        runtime.shutdown_timeout(Duration::from_millis(100));
        result
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// Until `body` returns, or has not done so `rest_max` after it was told to end.
async fn until_rest(
    body: impl Future<Output = anyhow::Result<()>>,
    rest_max: Option<Duration>,
) -> anyhow::Result<()> {
    let late = async {
        let ordered = shutdown::ordered().await;
        match rest_max {
            Some(rest_max) => sleep_until(ordered + rest_max).await,
            None => std::future::pending().await,
        }
    };
    tokio::select! {
        result = body => result,
        () = late => Err(anyhow::anyhow!("did not come to rest within {REST_MAX:.0?}")),
    }
}

/// Ends each life, waits for what is under way, and takes the node out of the graph.
async fn leave(name: &str, graph: &Graph) {
    shutdown::order();
    let rest_end = shutdown::ordered().await + REST_MAX;
    let deadline = rest_end.max(Instant::now() + ANSWER_MIN);
    if !REQUESTS.all_ended(deadline).await {
        log::error!("{name}: ended before all requests were answered");
    }
    let subscriptions = graph.subscriptions();
    subscriptions
        .iter()
        .for_each(|subscription| subscription.close());
    let deadline = Instant::now() + FLUSH_MAX;
    if !THREADS.all_ended(deadline).await {
        log::warn!("{name}: ended before all callbacks were done");
    }
    graph.flush(deadline).await;
    graph.registrations.withdraw(FAREWELL_MAX).await;
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("cannot start the runtime")
}

/// A panic would end one callback or task in silence, leaving a node that hears nothing. A process that is gone is started
/// again by roslaunch.
fn abort_on_panic() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        report(info);
        std::process::abort();
    }));
}
