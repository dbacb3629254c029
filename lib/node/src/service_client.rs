//! Calls of services that end when nobody waits for them any more.
//!
//! rosrust's client waits for ever on a server that accepts and never answers, and a call that was given up keeps its
//! connection: the server could not know that its caller has left.

use crate::bounded::{Request, Response};
use crate::layout::MESSAGE_BYTES_MAX;
use crate::master;
use crate::service::{CallError, resolved};
use crate::tcpros::{Limited, block, header, read_block, read_header};
use msg::service::Service;
use rosrust::RosMsg;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pause between two looks for a service that is not there yet.
const LOOK_PERIOD: Duration = Duration::from_millis(100);

/// Calls the service `name` and waits for the answer until `deadline` has passed. Given up before, it hangs up.
pub(crate) async fn call<S: Service>(
    name: &str,
    request: S::Request,
    deadline: Duration,
) -> Result<S::Response, CallError> {
    let line = Line::default();
    let hang_up = HangUp(line.clone());
    let owned = name.to_owned();
    let work =
        tokio::task::spawn_blocking(move || call_blocking::<S>(&owned, request, deadline, &line));
    let answer = tokio::time::timeout(deadline, work).await;
    drop(hang_up);
    match answer {
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

/// The connection of a call, shared by who works on it and who gives it up.
#[derive(Clone, Default)]
struct Line(Arc<Mutex<State>>);

#[derive(Default)]
enum State {
    #[default]
    Idle,
    Connected(TcpStream),
    GivenUp,
}

impl Line {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_given_up(&self) -> bool {
        matches!(*self.state(), State::GivenUp)
    }

    /// Whether the call may use its connection.
    fn connected(&self, stream: &TcpStream) -> io::Result<bool> {
        let mut state = self.state();
        if matches!(*state, State::GivenUp) {
            return Ok(false);
        }
        *state = State::Connected(stream.try_clone()?);
        Ok(true)
    }
}

/// Gives the call up when dropped.
struct HangUp(Line);

impl Drop for HangUp {
    fn drop(&mut self) {
        if let State::Connected(stream) = std::mem::replace(&mut *self.0.state(), State::GivenUp) {
            // Fails where the server has hung up already.
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

fn call_blocking<S: Service>(
    name: &str,
    request: S::Request,
    deadline: Duration,
    line: &Line,
) -> Result<S::Response, CallError> {
    let failed = |reason: String| CallError::Failed {
        name: name.into(),
        reason,
    };
    let service = resolved(name).map_err(|error| failed(error.to_string()))?;
    let start = Instant::now();
    // Half of the time to appear, so that an absent service is told from a slow one.
    let Some(stream) = connect(&service, deadline / 2, line) else {
        return Err(CallError::Absent {
            name: name.into(),
            waited: start.elapsed(),
        });
    };
    let left = deadline.saturating_sub(start.elapsed());
    match exchange::<S>(&stream, &service, request, left) {
        Ok(Ok(response)) => Ok(response),
        Ok(Err(reason)) => Err(failed(reason)),
        // Told alike whoever notices first.
        Err(error) if error.kind() == io::ErrorKind::TimedOut => Err(CallError::Deadline {
            name: name.into(),
            deadline,
        }),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Err(failed(
            "it hung up before it answered; has its node ended?".into(),
        )),
        Err(error) => Err(failed(error.to_string())),
    }
}

/// A connection to the server, as soon as there is one; `None` where there is none in time or nobody waits any more.
fn connect(service: &str, patience: Duration, line: &Line) -> Option<TcpStream> {
    let end = Instant::now() + patience;
    while !line.is_given_up() {
        let left = end.checked_duration_since(Instant::now())?;
        let dialled = master::lookup_service(service).and_then(|address| dial(address, left));
        match dialled {
            Ok(stream) => return line.connected(&stream).ok()?.then_some(stream),
            Err(_) => std::thread::sleep(LOOK_PERIOD.min(left)),
        }
    }
    None
}

fn dial(address: Option<String>, patience: Duration) -> io::Result<TcpStream> {
    let address = address.ok_or(io::ErrorKind::NotFound)?;
    let address = address.to_socket_addrs()?.next();
    TcpStream::connect_timeout(&address.ok_or(io::ErrorKind::NotFound)?, patience)
}

/// The response, or the server's words why there is none.
fn exchange<S: Service>(
    stream: &TcpStream,
    service: &str,
    request: S::Request,
    patience: Duration,
) -> io::Result<Result<S::Response, String>> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(patience.max(LOOK_PERIOD)))?;
    let mut writer = stream;
    let mut reader = Limited::new(stream, patience);
    writer.write_all(&header(&[
        ("callerid", &rosrust::name()),
        ("service", service),
        ("md5sum", &S::md5sum()),
        ("type", &S::msg_type()),
    ]))?;
    let fields = read_header(&mut reader)?;
    if let Some(refusal) = fields.get("error") {
        return Ok(Err(refusal.clone()));
    }
    let mut bytes = Vec::new();
    Request::<S>(request).encode(&mut bytes)?;
    writer.write_all(&block(&bytes))?;
    let mut good = [0];
    reader.read_exact(&mut good)?;
    let answer = read_block(&mut reader, MESSAGE_BYTES_MAX)?;
    if good == [0] {
        return Ok(Err(String::from_utf8_lossy(&answer).into_owned()));
    }
    Response::<S>::decode(&answer[..]).map(|Response(response)| Ok(response))
}
