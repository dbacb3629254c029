//! What the kernel counts of a TCP connection.

use std::os::fd::RawFd;

/// Bytes that went through a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TcpBytes {
    /// Sent by us and acknowledged; 0 for a connection that we accepted and have not answered.
    pub taken: u64,
    /// Received.
    pub received: u64,
}

/// Offsets of tcpi_bytes_acked and tcpi_bytes_received in the kernel's `struct tcp_info` (linux/tcp.h), where they have been
/// since Linux 4.1.
const TAKEN_AT: usize = 120;
const RECEIVED_AT: usize = 128;
const INFO_BYTES: usize = 136;

impl TcpBytes {
    /// Of the connection behind `fd`; `None` if there is none.
    #[allow(unsafe_code)] // no crate in use knows of these counters
    pub fn of(fd: RawFd) -> Option<Self> {
        let mut info = [0_u8; INFO_BYTES];
        let mut size = INFO_BYTES as libc::socklen_t;
        // SAFETY: the kernel writes at most `size` bytes to `info`, which is that long; any descriptor will do.
        let result = unsafe {
            libc::getsockopt(
                fd,
                libc::IPPROTO_TCP,
                libc::TCP_INFO,
                info.as_mut_ptr().cast(),
                &mut size,
            )
        };
        let number = |at: usize| Some(u64::from_ne_bytes(info.get(at..at + 8)?.try_into().ok()?));
        if result != 0 || (size as usize) < INFO_BYTES {
            return None;
        }
        Some(Self {
            taken: number(TAKEN_AT)?,
            received: number(RECEIVED_AT)?,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};
    use std::os::fd::AsRawFd;

    #[test]
    fn bytes_are_counted_both_ways() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut dialled = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (mut accepted, _) = listener.accept().unwrap();
        let counted = |stream: &TcpStream| TcpBytes::of(stream.as_raw_fd()).unwrap();
        assert_eq!(
            (counted(&accepted).taken, counted(&accepted).received),
            (0, 0)
        );
        assert_eq!(counted(&dialled).received, 0);
        accepted.write_all(&[7; 1000]).unwrap();
        dialled.read_exact(&mut [0; 1000]).unwrap();
        assert_eq!(
            (counted(&accepted).taken, counted(&dialled).received),
            (1000, 1000)
        );
        assert_eq!(TcpBytes::of(-1), None);
    }
}
