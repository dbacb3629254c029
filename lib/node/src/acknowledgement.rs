//! Acknowledgements sent at once, for publishers that wait for them.
//!
//! A publisher without TCP_NODELAY, as roscpp's is unless the subscriber's header asks for it, keeps a small message back
//! until the one before is acknowledged, which the system puts off for 40 ms: transforms then come in heaps of four.
//! rosrust's header cannot ask, so that its acknowledgement goes out as soon as a message was read.

use socket2::SockRef;
use std::os::fd::RawFd;
use std::sync::{PoisonError, RwLock};

/// Connections that this process made, as of late.
static DIALLED: RwLock<Vec<RawFd>> = RwLock::new(Vec::new());

/// Says which connections are to be acknowledged.
pub(crate) fn set_dialled(connections: Vec<RawFd>) {
    *DIALLED.write().unwrap_or_else(PoisonError::into_inner) = connections;
}

/// Acknowledges what was read from any of them; costs less than a microsecond for each.
pub(crate) fn send() {
    send_to(&DIALLED.read().unwrap_or_else(PoisonError::into_inner));
}

fn send_to(connections: &[RawFd]) {
    for connection in connections {
        // Fails where the connection has ended meanwhile; on another of the same number it does no harm.
        let _ = SockRef::from(connection).set_quickack(true);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};
    use std::os::fd::AsRawFd;
    use std::time::{Duration, Instant};

    const PAIRS: u32 = 20;

    /// Time for pairs of messages from a sender that waits for acknowledgements to a reader who is slow to give them.
    fn pairs_take(after_reading: impl Fn(&[RawFd])) -> Duration {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut reader = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let mut sender = listener.accept().unwrap().0;
        // A mark for the test of all sockets, which leaves alone what has limits of its own.
        SockRef::from(&sender).set_keepalive(true).unwrap();
        let begin = Instant::now();
        for _ in 0..PAIRS {
            SockRef::from(&reader).set_quickack(false).unwrap();
            for _ in 0..2 {
                sender.write_all(&[7; 100]).unwrap();
                reader.read_exact(&mut [0; 100]).unwrap();
                after_reading(&[reader.as_raw_fd()]);
            }
        }
        begin.elapsed()
    }

    #[test]
    fn senders_that_wait_are_answered_at_once() {
        let by_itself = pairs_take(|_| {});
        let at_once = pairs_take(send_to);
        assert!(at_once < by_itself / 4, "{at_once:?}, {by_itself:?}");
    }
}
