//! Time limits on the sockets that rosrust opens without any.
//!
//! rosrust reads the header of each new subscriber on the thread that accepts them, dials the publishers of a topic one
//! after the other, writes to all subscribers on one thread, and waits for answers without end. A peer that says nothing,
//! one that was stopped, or one whose cable was pulled holds up all others. Here such connections are ended from aside.

use crate::acknowledgement;
use crate::tcp_info::TcpBytes;
use crate::xmlrpc::authority;
use socket2::{SockRef, TcpKeepalive};
use std::collections::{HashMap, HashSet};
use std::net::{Shutdown, SocketAddr};
use std::os::fd::RawFd;
use std::time::{Duration, Instant};

/// How long somebody who dialled us may take for what earns an answer: a connection header, or a question.
const GREETING_MAX: Duration = Duration::from_secs(2);
/// How long somebody whom we dialled may take for the first byte.
const ANSWER_MAX: Duration = Duration::from_millis(2500);
/// The same for the master, which everybody asks at once when all starts, and without whom nobody can start.
const MASTER_ANSWER_MAX: Duration = Duration::from_secs(10);
/// Shorter connections are questions to the master or a node, or calls of services; a topic's lasts longer.
const LASTING: Duration = Duration::from_secs(5);
/// How long a full receive buffer of a peer may hold us up.
const WRITE_MAX: Duration = Duration::from_secs(2);
/// Silence of the network after which a peer is asked for a sign of life, and the pause between the three questions.
const KEEPALIVE_IDLE: Duration = Duration::from_secs(2);
const KEEPALIVE_INTERVAL: Duration = Duration::from_secs(1);
const KEEPALIVE_RETRIES: u32 = 3;

/// The TCP sockets of this process.
pub(crate) struct Sockets {
    master_port: Option<u16>,
    /// How old a connection must be for its end to be told.
    lasting: Duration,
    /// Connections, and when each was first seen.
    seen: HashMap<Connection, Instant>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Connection {
    fd: RawFd,
    local: SocketAddr,
    /// None while it is being made.
    peer: Option<SocketAddr>,
    /// Whether we dialled it.
    dialled: bool,
}

impl Sockets {
    /// Of a process that asks the master at this URI.
    pub fn new(master_uri: &str) -> Self {
        let port = authority(master_uri).and_then(|host| host.rsplit_once(':'));
        Self {
            master_port: port.and_then(|(_, port)| port.parse().ok()),
            lasting: LASTING,
            seen: HashMap::new(),
        }
    }

    /// Looks at all sockets there are: sets their limits, and ends what is over them. Returns the far ends of those
    /// dialled connections that are gone since last time and may have carried a topic.
    pub fn tend(&mut self) -> Vec<SocketAddr> {
        let now = Instant::now();
        let mut seen = HashMap::new();
        for connection in connections() {
            let since = *self.seen.get(&connection).unwrap_or(&now);
            if is_overdue(&connection, now - since, self.master_port) {
                let socket = SockRef::from(&connection.fd);
                log::debug!("ending a mute connection: {connection:?}");
                // Fails where it has ended meanwhile.
                let _ = socket.shutdown(Shutdown::Both);
            }
            seen.insert(connection, since);
        }
        let dialled = seen.keys().filter(|connection| connection.dialled);
        acknowledgement::set_dialled(dialled.map(|connection| connection.fd).collect());
        let before = std::mem::replace(&mut self.seen, seen);
        let there: HashSet<SocketAddr> = self.seen.keys().filter_map(|other| other.peer).collect();
        let carried = |(connection, since): (&Connection, &Instant)| {
            let peer = connection.peer.filter(|_| connection.dialled)?;
            let is_master = Some(peer.port()) == self.master_port;
            let lasted = now - *since >= self.lasting;
            (lasted && !is_master && !there.contains(&peer)).then_some(peer)
        };
        before.iter().filter_map(carried).collect()
    }
}

/// The connections of this process, their options set.
fn connections() -> Vec<Connection> {
    let (mut listening, mut connections) = (HashSet::new(), Vec::new());
    for fd in own_sockets() {
        let socket = SockRef::from(&fd);
        // Other kinds of sockets have no such address.
        let Some(local) = socket.local_addr().ok().and_then(|own| own.as_socket()) else {
            continue;
        };
        if let Err(error) = limit(&socket) {
            log::debug!("no time limits on the socket at {local}: {error}");
        }
        if matches!(socket.is_listener(), Ok(true)) {
            listening.insert(local.port());
        } else {
            let peer = socket.peer_addr().ok().and_then(|peer| peer.as_socket());
            let dialled = true;
            connections.push(Connection {
                fd,
                local,
                peer,
                dialled,
            });
        }
    }
    for connection in &mut connections {
        connection.dialled = !listening.contains(&connection.local.port());
    }
    connections
}

/// What a listener has, those whom it accepts inherit. Whoever has set limits of his own keeps them.
fn limit(socket: &SockRef) -> std::io::Result<()> {
    if socket.keepalive()? {
        return Ok(());
    }
    let keepalive = TcpKeepalive::new()
        .with_time(KEEPALIVE_IDLE)
        .with_interval(KEEPALIVE_INTERVAL)
        .with_retries(KEEPALIVE_RETRIES);
    socket.set_tcp_keepalive(&keepalive)?;
    socket.set_write_timeout(Some(WRITE_MAX))?;
    socket.set_nodelay(true)
}

fn is_overdue(connection: &Connection, age: Duration, master_port: Option<u16>) -> bool {
    let port = connection.peer.map(|peer| peer.port());
    let limit = match connection.dialled {
        false => GREETING_MAX,
        true if port.is_some() && port == master_port => MASTER_ANSWER_MAX,
        true => ANSWER_MAX,
    };
    if age < limit {
        return false;
    }
    match (connection.peer, TcpBytes::of(connection.fd)) {
        (None, _) => true,
        (_, Some(bytes)) if connection.dialled => bytes.received == 0,
        (_, Some(bytes)) => bytes.taken == 0,
        (_, None) => false,
    }
}

/// Descriptors of this process's sockets.
fn own_sockets() -> Vec<RawFd> {
    let Ok(entries) = std::fs::read_dir("/proc/self/fd") else {
        return Vec::new();
    };
    let is_socket = |path: &std::path::Path| {
        std::fs::read_link(path).is_ok_and(|target| target.to_string_lossy().starts_with("socket:"))
    };
    entries
        .flatten()
        .filter(|entry| is_socket(&entry.path()))
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::io::{Read, Write};
    use std::net::{TcpListener, TcpStream};

    /// One test, since it looks at all sockets of the process.
    #[test]
    fn mute_peers_are_given_up_and_lost_connections_told() {
        let mut sockets = Sockets::new("http://localhost:11311");
        assert_eq!(sockets.master_port, Some(11311));
        sockets.lasting = Duration::ZERO;
        let ours = TcpListener::bind("127.0.0.1:0").unwrap();
        let theirs = TcpListener::bind("127.0.0.1:0").unwrap();
        let (own_address, far_address) = (ours.local_addr().unwrap(), theirs.local_addr().unwrap());

        // Here both ends of all connections are our own.
        let mut mute = TcpStream::connect(own_address).unwrap();
        mute.write_all(&[0xff; 4]).unwrap();
        let (mut greeting, _) = ours.accept().unwrap();
        let mut polite = TcpStream::connect(own_address).unwrap();
        let (mut greeted, _) = ours.accept().unwrap();
        greeted.write_all(b"answer").unwrap();
        polite.read_exact(&mut [0; 6]).unwrap();
        let lost = TcpStream::connect(far_address).unwrap();
        assert!(sockets.tend().is_empty());
        assert!(greeted.nodelay().unwrap() && greeted.write_timeout().unwrap().is_some());
        drop(lost);
        assert_eq!(sockets.tend(), [far_address]);

        let reader = std::thread::spawn(move || greeting.read_to_end(&mut Vec::new()));
        let begin = Instant::now();
        while !reader.is_finished() && begin.elapsed() < 2 * ANSWER_MAX {
            std::thread::sleep(Duration::from_millis(100));
            sockets.tend();
        }
        assert!(reader.is_finished(), "a mute connection ends");
        let took = begin.elapsed();
        assert!(
            took > GREETING_MAX / 2 && took < 2 * GREETING_MAX,
            "{took:?}"
        );
        greeted.write_all(b"more").unwrap();
        polite.read_exact(&mut [0; 4]).unwrap();
    }
}
