//! The master's list of services. rosrust registers only servers of its own making.

use crate::environment;
use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// How long the master has to answer.
const DEADLINE: Duration = Duration::from_secs(2);
/// Bytes of an answer that are read at most; the answers asked for here are short.
const ANSWER_BYTES_MAX: usize = 64 << 10;

/// Lists the service `name` at `uri` (rosrpc://HOST:PORT), in place of any other of that name.
pub(crate) fn register_service(name: &str, uri: &str) -> io::Result<()> {
    let arguments = [&rosrust::name()[..], name, uri, &rosrust::uri()];
    call("registerService", &arguments).map(drop)
}

/// Takes the service `name` at `uri` from the list.
pub(crate) fn unregister_service(name: &str, uri: &str) -> io::Result<()> {
    call("unregisterService", &[&rosrust::name(), name, uri]).map(drop)
}

/// Where the service `name` is: host and port. `None` where nobody offers it.
pub(crate) fn lookup_service(name: &str) -> io::Result<Option<String>> {
    let answer = call("lookupService", &[&rosrust::name(), name])?;
    Ok(rosrpc_address(&answer).map(str::to_owned))
}

/// Calls a method of the master with text arguments; returns the body of the answer.
fn call(method: &str, arguments: &[&str]) -> io::Result<String> {
    let end = Instant::now() + DEADLINE;
    let uri = environment::master_uri();
    let host = environment::authority(&uri).ok_or(io::ErrorKind::InvalidInput)?;
    let address = host.to_socket_addrs()?.next();
    let address = address.ok_or(io::ErrorKind::NotFound)?;
    let mut stream = TcpStream::connect_timeout(&address, DEADLINE)?;
    stream.set_write_timeout(Some(DEADLINE))?;
    stream.write_all(request(host, method, arguments).as_bytes())?;
    let answer = read_answer(&mut stream, end)?;
    match answer.split_once("\r\n\r\n") {
        Some((head, body)) if head.split_whitespace().nth(1) == Some("200") => Ok(body.into()),
        _ => Err(io::Error::other(format!("the master refuses {method}"))),
    }
}

fn request(host: &str, method: &str, arguments: &[&str]) -> String {
    let parameters: String = arguments
        .iter()
        .map(|text| format!("<param><value><string>{text}</string></value></param>"))
        .collect();
    let body = format!(
        "<?xml version=\"1.0\"?><methodCall><methodName>{method}</methodName>\
         <params>{parameters}</params></methodCall>"
    );
    format!(
        "POST /RPC2 HTTP/1.1\r\nHost: {host}\r\nContent-Type: text/xml\r\nConnection: close\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    )
}

/// Reads up to the end of the XML, or of the stream.
fn read_answer(stream: &mut TcpStream, end: Instant) -> io::Result<String> {
    let (mut answer, mut piece) = (Vec::new(), [0; 4096]);
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        let count = stream.read(&mut piece)?;
        answer.extend_from_slice(&piece[..count]);
        let complete = answer.windows(17).any(|tail| tail == b"</methodResponse>");
        if count == 0 || complete || answer.len() > ANSWER_BYTES_MAX {
            return Ok(String::from_utf8_lossy(&answer).into_owned());
        }
    }
}

/// Host and port in an answer that has a service's URI.
fn rosrpc_address(answer: &str) -> Option<&str> {
    let (_, rest) = answer.split_once("rosrpc://")?;
    let address = rest.split(['<', '/']).next()?;
    let (_, port) = address.rsplit_once(':')?;
    port.parse::<u16>().is_ok().then_some(address)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_found_in_answers() {
        let answer =
            |uri: &str| format!("<value><int>1</int></value><value><string>{uri}</string></value>");
        let found = answer("rosrpc://arm:4711/");
        assert_eq!(rosrpc_address(&found), Some("arm:4711"));
        assert_eq!(
            rosrpc_address(&answer("rosrpc://10.0.0.2:80")),
            Some("10.0.0.2:80")
        );
        assert_eq!(rosrpc_address(&answer("rosrpc://arm")), None);
        assert_eq!(rosrpc_address(&answer("unknown service")), None);
    }
}
