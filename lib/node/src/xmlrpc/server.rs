//! The XML-RPC server of a node's slave API, called by the master and by other nodes.

use super::http;
use super::value::{Value, decode_call, encode_fault, encode_response};
use crate::callers::{Capacity, accept_all};
use crate::tcpros::set_options;
use std::io;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;

/// Time limit for a request to arrive once its connection stands, and for its answer to be taken.
const PATIENCE: Duration = Duration::from_secs(5);
/// Keep-alive: how long an idle connection stays open for a next request. Clients connect again after that.
const IDLE_MAX: Duration = Duration::from_secs(60);

/// Answers the call of a method with these arguments, or says why not.
pub(crate) trait Respond:
    Fn(&str, Vec<Value>) -> Result<Value, String> + Send + Sync + 'static
{
}
impl<F: Fn(&str, Vec<Value>) -> Result<Value, String> + Send + Sync + 'static> Respond for F {}

/// Serves all connections, until dropped.
pub(crate) async fn serve(listener: TcpListener, respond: Arc<impl Respond>) {
    let answer = move |stream, _, _| {
        let respond = Arc::clone(&respond);
        async move { answer_all(stream, &*respond).await }
    };
    accept_all(listener, Capacity::CALLS, "XML-RPC".into(), answer).await;
}

async fn answer_all(mut stream: TcpStream, respond: &impl Respond) -> io::Result<()> {
    set_options(&stream)?;
    let mut patience = PATIENCE;
    loop {
        let (_, body) = timeout(patience, http::read(&mut stream)).await??;
        let answer = match decode_call(&body) {
            Ok((method, arguments)) => respond(&method, arguments),
            Err(error) => Err(error.to_string()),
        };
        let body = match answer {
            Ok(value) => encode_response(&value),
            Err(reason) => encode_fault(&reason),
        };
        timeout(PATIENCE, http::write(&mut stream, "HTTP/1.1 200 OK", &body)).await??;
        patience = IDLE_MAX;
    }
}
