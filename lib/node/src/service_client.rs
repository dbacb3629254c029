//! Calls of services that end when nobody waits for them any more.
//!
//! The end of the connection tells the server that its caller has left.

use crate::bounded;
use crate::layout::MESSAGE_BYTES_MAX;
use crate::life::Life;
use crate::tcpros::{block, header, read_block, read_header, set_options};
use crate::{master, names};
use msg::service::Service;
use rosrust::RosMsg;
use std::io;
use std::time::Duration;
use thiserror::Error;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::ReadHalf;
use tokio::time::{sleep, timeout};

/// Pause between two looks for a service that is not there yet.
const LOOK_PERIOD: Duration = Duration::from_millis(100);
/// How long the server of a call that was given up has to bring to rest what it moves, and to say so.
const REST_PATIENCE: Duration = Duration::from_millis(1500);

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

/// The response, or the server's words why there is none.
type Answer<S> = Result<<S as rosrust::ServicePair>::Response, String>;

/// What ends a call before its answer.
enum End {
    Deadline,
    Life(String),
}

/// Calls the service `name`, which has until `deadline` has passed or `life` has ended.
///
/// A call that is given up for either hangs up, so that the server's own [`Life`] ends. It returns when the server has said
/// that it is done, or after 1.5 s. Dropped, it hangs up without waiting.
pub(crate) async fn call<S: Service>(
    name: &str,
    request: S::Request,
    deadline: Duration,
    life: &Life,
) -> Result<S::Response, CallError> {
    let failed = |reason: String| CallError::Failed {
        name: name.into(),
        reason,
    };
    let ended = |end| match end {
        End::Deadline => CallError::Deadline {
            name: name.into(),
            deadline,
        },
        End::Life(reason) => CallError::GivenUp {
            name: name.into(),
            reason,
        },
    };
    let service = names::resolve(name).map_err(|error| failed(format!("{error:#}")))?;
    let mut bytes = Vec::new();
    let encoded = request.encode(&mut bytes);
    encoded.map_err(|error| failed(error.to_string()))?;
    let end = async {
        tokio::select! {
            biased;
            reason = life.ended() => End::Life(reason),
            () = sleep(deadline) => End::Deadline,
        }
    };
    tokio::pin!(end);
    let mut stream = tokio::select! {
        biased;
        end = &mut end => return Err(match end {
            End::Deadline => CallError::Absent { name: name.into(), waited: deadline },
            end => ended(end),
        }),
        stream = connect(&service) => stream,
    };
    let asked = tokio::select! {
        biased;
        end = &mut end => return Err(ended(end)),
        asked = ask::<S>(&mut stream, &service, &bytes) => asked,
    };
    asked.map_err(|error| failed(error.to_string()))?;
    let (mut reader, mut writer) = stream.split();
    let answer = read_answer::<S>(&mut reader);
    tokio::pin!(answer);
    tokio::select! {
        biased;
        answer = &mut answer => match answer {
            Ok(answer) => answer.map_err(failed),
            Err(error) => Err(failed(error.to_string())),
        },
        end = &mut end => {
            // Fails where the server has hung up already.
            let _ = writer.shutdown().await;
            let _ = timeout(REST_PATIENCE, answer).await;
            Err(ended(end))
        }
    }
}

/// A connection to the server, as soon as there is one.
async fn connect(service: &str) -> TcpStream {
    loop {
        if let Ok(stream) = dial(service).await {
            return stream;
        }
        sleep(LOOK_PERIOD).await;
    }
}

async fn dial(service: &str) -> io::Result<TcpStream> {
    let address = master::lookup_service(service).await;
    TcpStream::connect(address.ok_or(io::ErrorKind::NotFound)?).await
}

/// Introduces this node, and sends the request once the server has accepted that.
async fn ask<S: Service>(stream: &mut TcpStream, service: &str, request: &[u8]) -> io::Result<()> {
    set_options(stream)?;
    let introduction = header(&[
        ("callerid", names::own()),
        ("service", service),
        ("md5sum", &S::md5sum()),
        ("type", &S::msg_type()),
    ]);
    stream.write_all(&introduction).await?;
    if let Some(refusal) = read_header(stream).await?.remove("error") {
        return Err(io::Error::other(refusal));
    }
    stream.write_all(&block(request)).await
}

async fn read_answer<S: Service>(reader: &mut ReadHalf<'_>) -> io::Result<Answer<S>> {
    let is_good = reader.read_u8().await? != 0;
    let mut answer = read_block(reader, MESSAGE_BYTES_MAX).await?;
    if !is_good {
        return Ok(Err(String::from_utf8_lossy(&answer).into_owned()));
    }
    bounded::response::<S>(&mut answer).map(Ok)
}
