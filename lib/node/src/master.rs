//! The ROS master and its parameter server: <https://wiki.ros.org/ROS/Master_API>.

use crate::xmlrpc::{self, Value};
use crate::{environment, names};
use std::collections::BTreeMap;
use std::io;
use std::time::Duration;
use tokio::runtime::Handle;

/// How long the master has to answer: it is asked by everybody at once when all starts.
const DEADLINE: Duration = Duration::from_secs(5);

/// Nodes by the topics that they publish or read.
pub(crate) type Topics = BTreeMap<String, Vec<String>>;

/// Calls `method` of the master, whose first argument is always this node's name.
pub(crate) async fn call(method: &str, arguments: &[Value]) -> io::Result<Value> {
    let arguments = [&[names::own().into()], arguments].concat();
    xmlrpc::call_ros(&environment::master_uri(), method, &arguments, DEADLINE).await
}

/// Waits for an answer where nothing can be awaited; to be called within the runtime.
pub(crate) fn blocking<T>(answer: impl Future<Output = T>) -> T {
    tokio::task::block_in_place(|| Handle::current().block_on(answer))
}

/// Where the service `name` is: host and port. `None` where nobody offers it.
pub(crate) async fn lookup_service(name: &str) -> Option<String> {
    let uri = call("lookupService", &[name.into()]).await.ok()?;
    let address = uri.as_text()?.strip_prefix("rosrpc://")?;
    Some(address.trim_end_matches('/').to_owned())
}

/// Where the node `name` is.
pub(crate) async fn lookup_node(name: &str) -> io::Result<String> {
    let uri = call("lookupNode", &[name.into()]).await?;
    uri.into_text().ok_or_else(|| io::Error::other("no URI"))
}

/// The nodes that publish, and those that read each topic.
pub(crate) async fn topics() -> io::Result<[Topics; 2]> {
    let state = call("getSystemState", &[]).await?;
    let mut lists = state.into_array().unwrap_or_default().into_iter();
    let mut next = || lists.next().map(topics_of).unwrap_or_default();
    Ok([next(), next()])
}

fn topics_of(list: Value) -> Topics {
    let entry = |entry: Value| {
        let mut entry = entry.into_array()?.into_iter();
        Some((entry.next()?.into_text()?, entry.next()?.into_texts()))
    };
    let entries = list.into_array().unwrap_or_default();
    entries.into_iter().filter_map(entry).collect()
}
