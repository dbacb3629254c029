//! Connection headers and length-prefixed blocks of TCPROS, bounded in size; the reader bounds the time.
//!
//! <https://wiki.ros.org/ROS/TCPROS>

use socket2::{SockRef, TcpKeepalive};
use std::collections::HashMap;
use std::io;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt};
use tokio::net::TcpStream;

/// Size limit of a connection header, bytes. Most have some hundred; the longest field is the message definition.
const HEADER_BYTES_MAX: usize = 256 << 10;

/// Silence after which a peer's computer counts as unreachable where something may be moving for it.
pub(crate) const PROMPT: Duration = Duration::from_secs(3);
/// The same for a peer that only listens. TCP retransmits by itself what was lost where the computer is back earlier. A
/// connection that this end has given up is noticed by rospy and roscpp only through their own keepalive, after 60 s; they
/// hear nothing until then.
pub(crate) const PATIENT: Duration = Duration::from_secs(60);

/// Number of keepalive probes within the silence that is allowed.
const PROBES: u32 = 3;

/// Sends at once, and notices within 3 s when the peer cannot be reached any more.
pub(crate) fn set_options(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    set_silence_max(stream, PROMPT)
}

/// Ends the connection with an error when the peer's computer has said nothing for so long, be it idle (keepalive) or with
/// something on the way (user timeout, as keepalive does not probe then).
pub(crate) fn set_silence_max(stream: &TcpStream, silence_max: Duration) -> io::Result<()> {
    let period = silence_max / PROBES;
    let keepalive = TcpKeepalive::new()
        .with_time(period)
        .with_interval(period)
        .with_retries(PROBES - 1);
    let socket = SockRef::from(stream);
    socket.set_tcp_user_timeout(Some(silence_max))?;
    socket.set_tcp_keepalive(&keepalive)
}

/// Whether a connection ended because the peer's computer said nothing any more.
pub(crate) fn is_unreachable(error: &io::Error) -> bool {
    use io::ErrorKind::{HostUnreachable, NetworkUnreachable, TimedOut};
    matches!(
        error.kind(),
        TimedOut | HostUnreachable | NetworkUnreachable
    )
}

/// Reads a length and so many bytes; the memory grows as they arrive, never ahead of them.
pub(crate) async fn read_block(
    reader: &mut (impl AsyncRead + Unpin),
    bytes_max: usize,
) -> io::Result<Vec<u8>> {
    let length = reader.read_u32_le().await? as usize;
    if length > bytes_max {
        let text = format!("a block claims {length} bytes; the limit is {bytes_max}");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    let mut bytes = Vec::new();
    let read = reader.take(length as u64).read_to_end(&mut bytes).await?;
    if read < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(bytes)
}

/// Reads a connection header.
pub(crate) async fn read_header(
    reader: &mut (impl AsyncRead + Unpin),
) -> io::Result<HashMap<String, String>> {
    let block = read_block(reader, HEADER_BYTES_MAX).await?;
    let (mut rest, mut fields) = (&block[..], HashMap::new());
    while !rest.is_empty() {
        let field = read_block(&mut rest, HEADER_BYTES_MAX).await?;
        let field = String::from_utf8(field)
            .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "a header field is no text"))?;
        let (name, value) = field.split_once('=').ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidData, "a header field lacks its '='")
        })?;
        fields.insert(name.to_owned(), value.to_owned());
    }
    Ok(fields)
}

/// Encodes a connection header.
pub(crate) fn header(fields: &[(&str, &str)]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, value) in fields {
        body.extend(block(format!("{name}={value}").as_bytes()));
    }
    block(&body)
}

/// Encodes a block: the bytes, preceded by their length.
pub(crate) fn block(bytes: &[u8]) -> Vec<u8> {
    let mut block = (bytes.len() as u32).to_le_bytes().to_vec();
    block.extend_from_slice(bytes);
    block
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[tokio::test]
    async fn headers_come_back_as_they_were() {
        let sent = header(&[("service", "/scan"), ("md5sum", "*"), ("empty", "")]);
        let fields = read_header(&mut &sent[..]).await.unwrap();
        assert_eq!(fields.len(), 3);
        assert_eq!(fields["service"], "/scan");
        assert_eq!(fields["empty"], "");
    }

    #[tokio::test]
    async fn what_is_no_header_is_an_error_and_allocates_nothing() {
        let no_equals = block(&block(b"word"));
        let not_text = block(&block(&[b'a', b'=', 0xff]));
        for bad in [
            &u32::MAX.to_le_bytes()[..],
            &[4, 0, 0, 0, 0xff, 0xff, 0xff, 0xff],
            &[9, 0, 0, 0, 1],
            &no_equals,
            &not_text,
        ] {
            assert!(read_header(&mut &bad[..]).await.is_err(), "{bad:?}");
        }
    }
}
