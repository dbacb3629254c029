//! A server of services that knows whether its callers are still there.
//!
//! A caller that waits keeps its connection open; the handler is told when it ends.

use crate::bounded;
use crate::callers::{Capacity, Place, accept_all, listen};
use crate::layout::MESSAGE_BYTES_MAX;
use crate::life::Life;
use crate::names;
use crate::shutdown::{self, REQUESTS};
use crate::tcpros::{block, header, read_block, read_header, set_options};
use msg::service::Service;
use rosrust::RosMsg;
use std::collections::HashMap;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

/// How long a caller may take for its header, for a request once begun, and for taking the answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Pause between two looks at a connection on which a next request waits already: its end cannot be seen behind that.
const LOOK_PERIOD: Duration = Duration::from_millis(50);

/// The response to a request, or why there is none.
pub type Answer<S> = Result<<S as rosrust::ServicePair>::Response, String>;

/// An async closure that answers the requests of a service. Its [`Life`] ends when nobody waits for the answer any more.
pub trait Handler<S: Service>:
    Fn(S::Request, Life) -> <Self as Handler<S>>::Future + Send + Sync + 'static
{
    /// What it returns.
    type Future: Future<Output = Answer<S>> + Send;
}

impl<S, H, F> Handler<S> for H
where
    S: Service,
    H: Fn(S::Request, Life) -> F + Send + Sync + 'static,
    F: Future<Output = Answer<S>> + Send,
{
    type Future = F;
}

/// A service that this node offers, until dropped.
pub struct Server {
    port: u16,
    accepting: JoinHandle<()>,
}

impl Server {
    /// Serves `name`, resolved, at an address that callers of `host` reach.
    ///
    /// # Errors
    /// Where no port can be had.
    pub(crate) fn start<S: Service>(
        name: &str,
        host: &str,
        handler: Arc<impl Handler<S>>,
    ) -> io::Result<Self> {
        let listener = listen(host)?;
        let port = listener.local_addr()?.port();
        let (name, what) = (Arc::<str>::from(name), format!("service {name}"));
        let serve = move |stream, peer, place: Arc<Place>| {
            let (name, handler) = (Arc::clone(&name), Arc::clone(&handler));
            async move {
                let served = serve_caller(stream, peer, &name, &*handler, &place).await;
                served.inspect_err(|error| {
                    if error.kind() != io::ErrorKind::UnexpectedEof {
                        log::warn!("service {name}: {error}");
                    }
                })
            }
        };
        let accepting = tokio::spawn(accept_all(listener, Capacity::CALLS, what, serve));
        Ok(Self { port, accepting })
    }

    pub(crate) fn port(&self) -> u16 {
        self.port
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.accepting.abort();
    }
}

async fn serve_caller<S: Service>(
    mut stream: TcpStream,
    peer: SocketAddr,
    name: &str,
    handler: &impl Handler<S>,
    place: &Place,
) -> io::Result<()> {
    set_options(&stream)?;
    let fields = timeout(PATIENCE, read_header(&mut stream)).await??;
    let is_set = |field: &str| fields.get(field).is_some_and(|value| value == "1");
    if !is_set("probe")
        && let Err(mismatch) = check_header::<S>(&fields, name)
    {
        stream.write_all(&header(&[("error", &mismatch)])).await?;
        return Err(io::Error::new(io::ErrorKind::InvalidData, mismatch));
    }
    let accepted = header(&[
        ("callerid", names::own()),
        ("md5sum", &S::md5sum()),
        ("type", &S::msg_type()),
    ]);
    stream.write_all(&accepted).await?;
    if is_set("probe") {
        return Ok(());
    }
    let caller = match fields.get("callerid") {
        Some(name) => format!("{name} at {}", peer.ip()),
        None => peer.to_string(),
    };
    loop {
        let mut request = read_request(&mut stream).await?;
        // The end of the process waits until the answer is out.
        let _work = REQUESTS.begin();
        let answer = if shutdown::is_ordered() {
            failure("the node is shutting down")
        } else if place.begin_use() {
            answer(&mut request, &stream, &caller, handler).await
        } else {
            failure(&format!(
                "too many calls of {name} at a time from {}",
                peer.ip()
            ))
        };
        place.end_use();
        timeout(PATIENCE, stream.write_all(&answer)).await??;
        if !is_set("persistent") {
            return Ok(());
        }
    }
}

/// A request, whenever it comes; once begun it has to go on.
async fn read_request(stream: &mut TcpStream) -> io::Result<Vec<u8>> {
    stream.readable().await?;
    timeout(PATIENCE, read_block(stream, MESSAGE_BYTES_MAX)).await?
}

fn check_header<S: Service>(fields: &HashMap<String, String>, name: &str) -> Result<(), String> {
    let expect = |field: &str, expected: &str| match fields.get(field) {
        Some(value) if value == expected || value == "*" => Ok(()),
        Some(value) => Err(format!("{field} is {value} where {name} has {expected}")),
        None => Err(format!("the caller of {name} does not give its {field}")),
    };
    expect("service", name)?;
    expect("md5sum", &S::md5sum())
}

/// The answer as it is sent: whether all went well, and the response or why not. The handler is told when the caller has
/// gone, and waited for all the same: it brings to rest what it moves.
async fn answer<S: Service>(
    request: &mut [u8],
    stream: &TcpStream,
    caller: &str,
    handler: &impl Handler<S>,
) -> Vec<u8> {
    let request = match bounded::request::<S>(request) {
        Ok(request) => request,
        Err(error) => return failure(&format!("the request cannot be read: {error}")),
    };
    let (end, ended) = oneshot::channel();
    let life = Life::until(async { ended.await.unwrap_or_default() });
    let response = handler(request, life);
    tokio::pin!(response);
    let response = tokio::select! {
        response = &mut response => response,
        reason = hung_up(stream, caller) => {
            // Nobody hears it where the handler did not keep its life.
            let _ = end.send(reason);
            response.await
        }
    };
    let mut bytes = Vec::new();
    let encoded = response.and_then(|response| {
        let encoded = response.encode(&mut bytes);
        encoded.map_err(|error| error.to_string())
    });
    match encoded {
        Ok(()) => [vec![1], block(&bytes)].concat(),
        Err(reason) => failure(&reason),
    }
}

fn failure(reason: &str) -> Vec<u8> {
    [vec![0], block(reason.as_bytes())].concat()
}

/// Returns why nobody waits at the other end any more; never while somebody does, who keeps the connection open.
async fn hung_up(stream: &TcpStream, caller: &str) -> String {
    loop {
        match stream.peek(&mut [0]).await {
            Ok(0) => return format!("the caller {caller} hung up or died"),
            Ok(_) => sleep(LOOK_PERIOD).await,
            Err(error) if error.kind() == io::ErrorKind::TimedOut => {
                return format!("the caller {caller} cannot be reached any more");
            }
            Err(error) => return format!("the caller {caller} hung up or died ({error})"),
        }
    }
}
