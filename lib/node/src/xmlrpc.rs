//! Calls of the ROS master and of nodes that end by their deadline; rosrust's own wait as long as TCP does.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// Bytes of an answer that are read at most; the answers asked for here are short.
const ANSWER_BYTES_MAX: usize = 64 << 10;

/// Host and port of a URI as ROS writes them: http://HOST:PORT/.
pub(crate) fn authority(uri: &str) -> Option<&str> {
    let rest = uri.strip_prefix("http://")?.trim_end_matches('/');
    let (_, port) = rest.rsplit_once(':')?;
    port.parse::<u16>().is_ok().then_some(rest)
}

/// The time in which `uri` (a node's or the master's) answers, whatever it says.
pub(crate) fn ping(uri: &str, deadline: Duration) -> io::Result<Duration> {
    let start = Instant::now();
    call(uri, "getPid", &[&rosrust_name()], deadline)?;
    Ok(start.elapsed())
}

/// URI of the node `name`, as the master at `uri` has it.
pub(crate) fn lookup_node(uri: &str, name: &str, deadline: Duration) -> io::Result<String> {
    let answer = call(uri, "lookupNode", &[&rosrust_name(), name], deadline)?;
    node_uri(&answer).ok_or_else(|| io::Error::other(format!("the master does not know {name}")))
}

fn rosrust_name() -> String {
    if rosrust::is_initialized() {
        rosrust::name()
    } else {
        "/unnamed".into()
    }
}

/// The port at which the node at `uri` publishes `topic`.
pub(crate) fn topic_port(uri: &str, topic: &str, deadline: Duration) -> io::Result<u16> {
    let protocols = "<array><data><value><array><data><value><string>TCPROS</string></value></data></array></value></data></array>";
    let values = [text(&rosrust_name()), text(topic), protocols.into()];
    let answer = call_with(uri, "requestTopic", &values, deadline)?;
    last_number(&answer).ok_or_else(|| io::Error::other(format!("{uri} does not publish {topic}")))
}

/// The last whole number in an answer, where it is a port.
fn last_number(answer: &str) -> Option<u16> {
    let ends = ["</i4>", "</int>"].map(|tag| answer.rfind(tag));
    let end = ends.into_iter().flatten().max()?;
    let (_, digits) = answer[..end].rsplit_once('>')?;
    digits.parse().ok().filter(|port| *port > 1)
}

/// Calls a method with text arguments; returns the body of the answer.
pub(crate) fn call(
    uri: &str,
    method: &str,
    arguments: &[&str],
    deadline: Duration,
) -> io::Result<String> {
    let values: Vec<_> = arguments.iter().map(|argument| text(argument)).collect();
    call_with(uri, method, &values, deadline)
}

/// A text as a value.
fn text(text: &str) -> String {
    format!("<string>{text}</string>")
}

fn call_with(uri: &str, method: &str, values: &[String], deadline: Duration) -> io::Result<String> {
    let end = Instant::now() + deadline;
    let host = authority(uri).ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("'{uri}' is no ROS URI"),
        )
    })?;
    let mut stream = TcpStream::connect_timeout(&resolve(host)?, deadline)?;
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(deadline))?;
    stream.write_all(request(host, method, values).as_bytes())?;
    let answer = read_answer(&mut stream, end)?;
    let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
    if head.split_whitespace().nth(1) != Some("200") {
        let status = head.lines().next().unwrap_or_default();
        return Err(io::Error::other(format!("answered '{status}'")));
    }
    Ok(body.into())
}

fn resolve(host: &str) -> io::Result<SocketAddr> {
    let unknown = || io::Error::new(io::ErrorKind::NotFound, format!("cannot resolve {host}"));
    host.to_socket_addrs()?.next().ok_or_else(unknown)
}

fn request(host: &str, method: &str, values: &[String]) -> String {
    let parameters: String = values
        .iter()
        .map(|value| format!("<param><value>{value}</value></param>"))
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

/// Reads up to the end of the XML, or of the stream; some servers leave the connection open.
fn read_answer(stream: &mut TcpStream, end: Instant) -> io::Result<String> {
    let (mut answer, mut piece) = (Vec::new(), [0; 4096]);
    loop {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        let count = stream.read(&mut piece).map_err(timed_out)?;
        answer.extend_from_slice(&piece[..count]);
        let complete = answer.windows(17).any(|tail| tail == b"</methodResponse>");
        if count == 0 || complete || answer.len() > ANSWER_BYTES_MAX {
            return Ok(String::from_utf8_lossy(&answer).into_owned());
        }
    }
}

/// A socket whose timeout has passed says that it would block.
fn timed_out(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::WouldBlock => io::ErrorKind::TimedOut.into(),
        _ => error,
    }
}

/// The URI in the master's answer: a status, words, and the URI.
fn node_uri(answer: &str) -> Option<String> {
    let begin = answer.find("http://")?;
    let uri = answer[begin..].split('<').next()?;
    authority(uri).map(|_| uri.into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn uris_are_taken_apart() {
        assert_eq!(authority("http://10.0.0.2:4711/"), Some("10.0.0.2:4711"));
        assert_eq!(authority("http://10.0.0.2/"), None);
        assert_eq!(authority("rosrpc://10.0.0.2:4711"), None);
        let answer = "<value><int>1</int></value><value><string>node api</string></value>\
                      <value><string>http://arm:4711/</string></value>";
        assert_eq!(node_uri(answer).as_deref(), Some("http://arm:4711/"));
        assert_eq!(node_uri("<value><int>-1</int></value>"), None);
    }

    #[test]
    fn a_mute_server_is_given_up() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let uri = format!("http://{}/", listener.local_addr().unwrap());
        let begin = Instant::now();
        let error = ping(&uri, Duration::from_millis(100)).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        assert!(begin.elapsed() < Duration::from_secs(2));
        drop(listener);
        let error = ping(&uri, Duration::from_secs(1)).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::ConnectionRefused);
    }

    #[test]
    fn an_answer_is_measured_and_a_refusal_is_told() {
        for (status, fine) in [("200 OK", true), ("404 Not Found", false)] {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let uri = format!("http://{}/", listener.local_addr().unwrap());
            let server = std::thread::spawn(move || {
                let (mut stream, _) = listener.accept().unwrap();
                let _ = stream.read(&mut [0; 1024]).unwrap();
                let answer = format!("HTTP/1.1 {status}\r\n\r\n<methodResponse></methodResponse>");
                stream.write_all(answer.as_bytes()).unwrap();
                stream
            });
            let result = ping(&uri, Duration::from_secs(5));
            server.join().unwrap();
            assert_eq!(result.is_ok(), fine, "{result:?}");
        }
    }
}
