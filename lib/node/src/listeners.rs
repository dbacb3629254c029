//! Who really listens to a topic of this node.
//!
//! rosrust counts a subscriber until a message to it cannot be written, and the master until it says goodbye; a client that
//! was killed does neither. The kernel knows: each topic has a port of its own, and a connection there is established
//! until one of its ends has closed it, or keepalive has found the other computer gone.

use crate::xmlrpc;
use std::io;
use std::time::Duration;

/// How long this node has to tell itself its topic's port.
const DEADLINE: Duration = Duration::from_secs(1);
/// `TCP_ESTABLISHED` of linux/tcp_states.h, as /proc/net/tcp has it.
const ESTABLISHED: &str = "01";

/// Established connections to `topic` (with its namespace), which this node publishes.
///
/// # Errors
/// This node does not publish it.
pub(crate) fn count(topic: &str) -> io::Result<usize> {
    let port = xmlrpc::topic_port(&rosrust::uri(), topic, DEADLINE)?;
    let table = std::fs::read_to_string("/proc/self/net/tcp")?;
    Ok(established_at(&table, port))
}

/// In a table like /proc/net/tcp: number, local address, remote address, state, …
fn established_at(table: &str, port: u16) -> usize {
    let end = format!(":{port:04X}");
    let is_counted = |line: &&str| {
        let mut fields = line.split_whitespace().skip(1);
        let (local, state) = (fields.next(), fields.nth(1));
        local.is_some_and(|local| local.ends_with(&end)) && state == Some(ESTABLISHED)
    };
    table.lines().skip(1).filter(is_counted).count()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::net::{TcpListener, TcpStream};

    #[test]
    fn connections_count_until_their_far_end_closes() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let count = || {
            let table = std::fs::read_to_string("/proc/self/net/tcp").unwrap();
            established_at(&table, address.port())
        };
        assert_eq!(count(), 0);
        let far_ends = [(); 2].map(|()| TcpStream::connect(address).unwrap());
        let _near_ends = [(); 2].map(|()| listener.accept().unwrap());
        assert_eq!(count(), 2);
        let [first, _second] = far_ends;
        drop(first);
        assert_eq!(count(), 1);
    }
}
