//! Connection headers and length-prefixed blocks as TCPROS has them, bounded in size and time.

use std::collections::HashMap;
use std::io::{self, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Bytes of a connection header that are taken at most; those of services have some hundred.
const HEADER_BYTES_MAX: usize = 16 << 10;

/// A stream from which nothing is waited for beyond a moment.
pub(crate) struct Limited<'a> {
    stream: &'a TcpStream,
    end: Instant,
}

impl<'a> Limited<'a> {
    pub fn new(stream: &'a TcpStream, patience: Duration) -> Self {
        let end = Instant::now() + patience;
        Self { stream, end }
    }
}

impl Read for Limited<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream
            .read(buffer)
            .map_err(|error| match error.kind() {
                // What a socket says whose timeout has passed.
                io::ErrorKind::WouldBlock => io::ErrorKind::TimedOut.into(),
                _ => error,
            })
    }
}

/// Reads a length and so many bytes; the memory grows as they arrive, never ahead of them.
pub(crate) fn read_block(reader: &mut impl Read, bytes_max: usize) -> io::Result<Vec<u8>> {
    let mut length = [0; 4];
    reader.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length) as usize;
    if length > bytes_max {
        let text = format!("a block claims {length} bytes; the limit is {bytes_max}");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    let mut bytes = Vec::new();
    let read = reader.take(length as u64).read_to_end(&mut bytes)?;
    if read < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(bytes)
}

/// Reads a connection header.
pub(crate) fn read_header(reader: &mut impl Read) -> io::Result<HashMap<String, String>> {
    let block = read_block(reader, HEADER_BYTES_MAX)?;
    let (mut rest, mut fields) = (&block[..], HashMap::new());
    while !rest.is_empty() {
        let field = read_block(&mut rest, HEADER_BYTES_MAX)?;
        let field = String::from_utf8(field)
            .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "a header field is no text"))?;
        let (name, value) = field.split_once('=').ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidData, "a header field lacks its '='")
        })?;
        fields.insert(name.to_owned(), value.to_owned());
    }
    Ok(fields)
}

/// A connection header, as it is sent.
pub(crate) fn header(fields: &[(&str, &str)]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, value) in fields {
        body.extend(block(format!("{name}={value}").as_bytes()));
    }
    block(&body)
}

/// Bytes after their length.
pub(crate) fn block(bytes: &[u8]) -> Vec<u8> {
    let mut block = (bytes.len() as u32).to_le_bytes().to_vec();
    block.extend_from_slice(bytes);
    block
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn headers_come_back_as_they_were() {
        let sent = header(&[("service", "/scan"), ("md5sum", "*"), ("empty", "")]);
        let fields = read_header(&mut &sent[..]).unwrap();
        assert_eq!(fields.len(), 3);
        assert_eq!(fields["service"], "/scan");
        assert_eq!(fields["empty"], "");
    }

    #[test]
    fn what_is_no_header_is_an_error_and_allocates_nothing() {
        let no_equals = block(&block(b"word"));
        let not_text = block(&block(&[b'a', b'=', 0xff]));
        for bad in [
            &u32::MAX.to_le_bytes()[..],
            &[4, 0, 0, 0, 0xff, 0xff, 0xff, 0xff],
            &[9, 0, 0, 0, 1],
            &no_equals,
            &not_text,
        ] {
            assert!(read_header(&mut &bad[..]).is_err(), "{bad:?}");
        }
    }
}
