//! XML-RPC, as the master and the nodes speak it, bounded in size and time.

mod http;
mod server;
mod value;

pub(crate) use server::serve;
pub(crate) use value::Value;

use std::io;
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::time::timeout;

/// Host and port of a URI as ROS writes them: http://HOST:PORT/.
pub(crate) fn authority(uri: &str) -> Option<&str> {
    let rest = uri.strip_prefix("http://")?.trim_end_matches('/');
    let (_, port) = rest.rsplit_once(':')?;
    port.parse::<u16>().is_ok().then_some(rest)
}

/// Calls `method` at `uri` and returns what it returns.
///
/// # Errors
/// Where there is no answer by the deadline, or the answer is a fault or makes no sense.
pub(crate) async fn call(
    uri: &str,
    method: &str,
    arguments: &[Value],
    deadline: Duration,
) -> io::Result<Value> {
    let host = authority(uri).ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("'{uri}' is no ROS URI"),
        )
    })?;
    let exchange = async {
        let mut stream = TcpStream::connect(host).await?;
        stream.set_nodelay(true)?;
        let body = value::encode_call(method, arguments);
        http::write(
            &mut stream,
            &format!("POST /RPC2 HTTP/1.1\r\nHost: {host}"),
            &body,
        )
        .await?;
        let (status, body) = http::read(&mut stream).await?;
        if status.split_whitespace().nth(1) != Some("200") {
            return Err(io::Error::other(format!("answered '{status}'")));
        }
        value::decode_response(&body)
    };
    let timed_out = |_| io::Error::from(io::ErrorKind::TimedOut);
    timeout(deadline, exchange).await.map_err(timed_out)?
}

/// Calls a method of ROS's APIs, whose answers are a status code, a status message and a value; gives the value.
///
/// # Errors
/// Also where the code says that the method failed.
pub(crate) async fn call_ros(
    uri: &str,
    method: &str,
    arguments: &[Value],
    deadline: Duration,
) -> io::Result<Value> {
    let answer = call(uri, method, arguments, deadline).await?;
    match <[Value; 3]>::try_from(answer.into_array().unwrap_or_default()) {
        Ok([Value::Int(1), _, value]) => Ok(value),
        Ok([Value::Int(_), words, _]) => Err(io::Error::other(format!(
            "{method}: {}",
            words.as_text().unwrap_or("failed")
        ))),
        _ => Err(io::Error::other(format!(
            "{method}: the answer makes no sense"
        ))),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use tokio::net::TcpListener;

    #[test]
    fn uris_are_taken_apart() {
        assert_eq!(authority("http://10.0.0.2:4711/"), Some("10.0.0.2:4711"));
        assert_eq!(authority("http://10.0.0.2/"), None);
        assert_eq!(authority("rosrpc://10.0.0.2:4711"), None);
    }

    #[tokio::test]
    async fn what_is_called_answers() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let uri = format!("http://{}/", listener.local_addr().unwrap());
        let echo = |method: &str, arguments: Vec<Value>| match method {
            "echo" => Ok(Value::Array(vec![
                1.into(),
                "".into(),
                Value::Array(arguments),
            ])),
            "refuse" => Ok(Value::Array(vec![(-1).into(), "no".into(), 0.into()])),
            _ => Err(format!("no method {method}")),
        };
        let server = tokio::spawn(serve(listener, std::sync::Arc::new(echo)));
        let sent = [
            Value::from("a <b> & c"),
            7.into(),
            Value::Double(0.5),
            Value::Bool(true),
        ];
        let second = Duration::from_secs(5);
        let back = call_ros(&uri, "echo", &sent, second).await.unwrap();
        assert_eq!(back, Value::Array(sent.to_vec()));
        for (method, words) in [("refuse", "refuse: no"), ("other", "no method other")] {
            let error = call_ros(&uri, method, &[], second).await.unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
        }
        server.abort();
    }

    #[tokio::test]
    async fn a_mute_server_is_given_up() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let uri = format!("http://{}/", listener.local_addr().unwrap());
        let error = call(&uri, "getPid", &[], Duration::from_millis(50))
            .await
            .unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
        drop(listener);
        let error = call(&uri, "getPid", &[], Duration::from_secs(5))
            .await
            .unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::ConnectionRefused);
    }
}
