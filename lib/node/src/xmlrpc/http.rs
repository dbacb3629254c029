//! As much of HTTP/1.1 (RFC 9112) as XML-RPC needs: a first line, a length, a body.

use std::io;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};

/// Size limit of the first line and the header fields together, bytes.
const HEAD_BYTES_MAX: usize = 16 << 10;
/// Size limit of a body, bytes: a parameter server may hold a robot's whole description.
const BODY_BYTES_MAX: usize = 8 << 20;

/// Writes a message with this first line and perhaps header fields after it.
pub(super) async fn write(
    stream: &mut (impl AsyncWrite + Unpin),
    head: &str,
    body: &str,
) -> io::Result<()> {
    let length = body.len();
    let message =
        format!("{head}\r\nContent-Type: text/xml\r\nContent-Length: {length}\r\n\r\n{body}");
    stream.write_all(message.as_bytes()).await
}

/// Reads a message: its first line and its body.
pub(super) async fn read(stream: &mut (impl AsyncRead + Unpin)) -> io::Result<(String, String)> {
    let (mut bytes, end) = (Vec::new(), b"\r\n\r\n");
    let head_end = loop {
        if let Some(place) = bytes.windows(end.len()).position(|four| four == end) {
            break place;
        }
        if bytes.len() > HEAD_BYTES_MAX {
            return Err(invalid("the header of an HTTP message is too long"));
        }
        if stream.read_buf(&mut bytes).await? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
    };
    let body = bytes.split_off(head_end + end.len());
    let head = String::from_utf8_lossy(&bytes).into_owned();
    let mut lines = head.lines();
    let first = lines.next().unwrap_or_default().to_owned();
    let mut length = None;
    for (name, value) in lines.filter_map(|line| line.split_once(':')) {
        if name.eq_ignore_ascii_case("content-length") {
            let value = value.trim().parse();
            length = Some(value.map_err(|_| invalid("the Content-Length is no number"))?);
        }
    }
    let body = read_body(stream, body, length).await?;
    String::from_utf8(body)
        .map(|body| (first, body))
        .map_err(|_| invalid("the body of an HTTP message is no text"))
}

/// Reads the rest of a body. Without a Content-Length it goes on to the end of the stream.
async fn read_body(
    stream: &mut (impl AsyncRead + Unpin),
    mut body: Vec<u8>,
    length: Option<usize>,
) -> io::Result<Vec<u8>> {
    let limit = length.unwrap_or(BODY_BYTES_MAX);
    if limit > BODY_BYTES_MAX {
        return Err(invalid("the body of an HTTP message is too long"));
    }
    let rest = limit.saturating_sub(body.len()) as u64;
    stream.take(rest).read_to_end(&mut body).await?;
    match length {
        Some(length) if body.len() < length => Err(io::ErrorKind::UnexpectedEof.into()),
        _ => Ok(body),
    }
}

fn invalid(text: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}
