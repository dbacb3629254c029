//! A server of services that knows whether its callers are still there.
//!
//! rosrust's own hides the connection from the handler, so that nobody learns that a caller has died, and reads each
//! caller's header on the thread that accepts the next one.

use crate::bounded::{Request, Response};
use crate::caller::Caller;
use crate::layout::MESSAGE_BYTES_MAX;
use crate::tcpros::{Limited, block, header, read_block, read_header};
use msg::service::Service;
use rosrust::RosMsg;
use socket2::{SockRef, TcpKeepalive};
use std::collections::HashMap;
use std::io::{self, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Callers at a time; more are turned away.
const CALLERS_MAX: usize = 64;
/// How long a caller may take for its header, for a request once begun, and for taking the answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// A caller whose computer says nothing is gone after 3 s: something may be moving for it.
const SIGN_OF_LIFE: TcpKeepalive = TcpKeepalive::new()
    .with_time(Duration::from_secs(1))
    .with_interval(Duration::from_secs(1))
    .with_retries(2);
/// How long a caller that keeps its connection may be silent between two requests.
const IDLE_MAX: Duration = Duration::from_secs(24 * 3600);

pub(crate) type Handler<S> = dyn Fn(
        <S as rosrust::ServicePair>::Request,
        Caller,
    ) -> Result<<S as rosrust::ServicePair>::Response, String>
    + Send
    + Sync;

/// Serves until dropped.
pub(crate) struct ServiceServer {
    port: u16,
    closed: Arc<AtomicBool>,
}

impl ServiceServer {
    /// Serves `name`, resolved, at an address that callers of `host` reach.
    pub fn start<S: Service>(name: &str, host: &str, handler: Arc<Handler<S>>) -> io::Result<Self> {
        let is_local = host == "localhost" || host.starts_with("127.");
        let listener = TcpListener::bind((if is_local { host } else { "0.0.0.0" }, 0))?;
        let port = listener.local_addr()?.port();
        let closed = Arc::new(AtomicBool::new(false));
        let (name, is_closed) = (name.to_owned(), Arc::clone(&closed));
        std::thread::Builder::new()
            .name(format!("service {name}"))
            .spawn(move || accept_all::<S>(&listener, &name, &is_closed, &handler))?;
        Ok(Self { port, closed })
    }

    pub fn port(&self) -> u16 {
        self.port
    }
}

impl Drop for ServiceServer {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
        // Wakes the thread that accepts.
        let _ = TcpStream::connect(("127.0.0.1", self.port));
    }
}

fn accept_all<S: Service>(
    listener: &TcpListener,
    name: &str,
    closed: &AtomicBool,
    handler: &Arc<Handler<S>>,
) {
    let callers = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        if closed.load(Ordering::Relaxed) {
            return;
        }
        let Ok(stream) = stream else {
            // Out of descriptors, for one; it may pass.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        let count = Counted::new(&callers);
        if callers.load(Ordering::Relaxed) > CALLERS_MAX {
            log::warn!("service {name}: a caller was turned away; there are {CALLERS_MAX} already");
            continue;
        }
        let (name, handler) = (name.to_owned(), Arc::clone(handler));
        let spawned = std::thread::Builder::new()
            .name("service call".into())
            .spawn(move || {
                let _count = count;
                if let Err(error) = serve_caller::<S>(stream, &name, &handler)
                    && error.kind() != io::ErrorKind::UnexpectedEof
                {
                    log::warn!("service {name}: {error}");
                }
            });
        if let Err(error) = spawned {
            log::error!("no thread for a caller: {error}");
        }
    }
}

/// One among the callers, until dropped.
struct Counted(Arc<AtomicUsize>);

impl Counted {
    fn new(count: &Arc<AtomicUsize>) -> Self {
        count.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(count))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn serve_caller<S: Service>(
    mut stream: TcpStream,
    name: &str,
    handler: &Arc<Handler<S>>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    SockRef::from(&stream).set_tcp_keepalive(&SIGN_OF_LIFE)?;
    let fields = read_header(&mut Limited::new(&stream, PATIENCE))?;
    let own_name = rosrust::name();
    let is_set = |field: &str| fields.get(field).is_some_and(|value| value == "1");
    if !is_set("probe")
        && let Err(mismatch) = check_header::<S>(&fields, name)
    {
        stream.write_all(&header(&[("error", &mismatch)]))?;
        return Err(io::Error::new(io::ErrorKind::InvalidData, mismatch));
    }
    stream.write_all(&header(&[
        ("callerid", &own_name),
        ("md5sum", &S::md5sum()),
        ("type", &S::msg_type()),
    ]))?;
    if is_set("probe") {
        return Ok(());
    }
    let caller_name = fields.get("callerid").map_or("", String::as_str);
    let caller = Caller::new(stream.try_clone()?, caller_name);
    let mut patience = PATIENCE;
    loop {
        let request = read_block(&mut Limited::new(&stream, patience), MESSAGE_BYTES_MAX)?;
        let answer = answer::<S>(&request, &caller, handler);
        stream.write_all(&answer)?;
        if !is_set("persistent") {
            return Ok(());
        }
        patience = IDLE_MAX;
    }
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

/// The answer as it is sent: whether all went well, and the response or why not.
fn answer<S: Service>(bytes: &[u8], caller: &Caller, handler: &Arc<Handler<S>>) -> Vec<u8> {
    let response = Request::<S>::decode(bytes)
        .map_err(|error| format!("the request cannot be read: {error}"))
        .and_then(|Request(request)| handler(request, caller.clone()))
        .and_then(|response| {
            let mut bytes = Vec::new();
            let encoded = Response::<S>(response).encode(&mut bytes);
            encoded.map(|()| bytes).map_err(|error| error.to_string())
        });
    let (good, bytes) = match response {
        Ok(bytes) => (1, bytes),
        Err(reason) => (0, reason.into_bytes()),
    };
    let mut answer = vec![good];
    answer.extend(block(&bytes));
    answer
}
