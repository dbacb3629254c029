//! The connections that a server has at a time, and which of them make room for a new one.

use std::collections::HashMap;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::time::sleep;

/// Pause after a connection that could not be accepted.
const RETRY: Duration = Duration::from_millis(50);

/// How many connections a server has at a time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Capacity {
    /// Connections of all computers together.
    pub connections: usize,
    /// Connections of one computer that are in use, so that others find room whatever it asks for.
    pub in_use_per_peer: usize,
}

impl Capacity {
    /// Capacity of a service, and of the slave API's server.
    pub const CALLS: Self = Self {
        connections: 64,
        in_use_per_peer: 16,
    };
    /// Capacity of all topics that a node publishes together: a bag recorder takes one connection for each.
    pub const SUBSCRIBERS: Self = Self {
        connections: 256,
        in_use_per_peer: 192,
    };
}

/// The callers of a server. Clones share them.
///
/// Only those in use keep their place for sure: a request is worked on, or a topic is sent. Where all places are taken, the
/// computer with the most connections loses the one that has been idle longest, be it that its header has not come or that
/// it keeps a persistent connection.
#[derive(Clone)]
pub(crate) struct Callers {
    capacity: Capacity,
    table: Arc<Mutex<Table>>,
}

#[derive(Default)]
struct Table {
    places: HashMap<u64, Entry>,
    /// Counts what happens, so that entries can be ordered by it.
    events: u64,
}

struct Entry {
    peer: IpAddr,
    is_in_use: bool,
    /// Number of the latest event that concerned this entry, for the order in which connections became idle.
    last_event: u64,
    /// Notified when the connection has to make room for another.
    put_out: Arc<Notify>,
}

/// The place that a connection takes among the callers, until dropped.
pub(crate) struct Place {
    callers: Callers,
    id: u64,
    put_out: Arc<Notify>,
}

/// A listener at an address that others reach at `host`.
///
/// # Errors
/// Where no port can be had.
pub(crate) fn listen(host: &str) -> io::Result<TcpListener> {
    let is_local = host == "localhost" || host.starts_with("127.");
    let listener = std::net::TcpListener::bind((if is_local { host } else { "0.0.0.0" }, 0))?;
    listener.set_nonblocking(true)?;
    TcpListener::from_std(listener)
}

/// Accepts connections for ever. Each is served by a task of its own until it ends, or until it has to make room for another.
pub(crate) async fn accept_all<F>(
    listener: TcpListener,
    capacity: Capacity,
    what: String,
    serve: impl Fn(TcpStream, SocketAddr, Arc<Place>) -> F,
) where
    F: Future<Output = io::Result<()>> + Send + 'static,
{
    let callers = Callers::new(capacity);
    let what: Arc<str> = what.into();
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            // Out of descriptors, for one; it may pass.
            sleep(RETRY).await;
            continue;
        };
        let Some(place) = callers.enter(peer.ip()).map(Arc::new) else {
            log::warn!("{what}: {peer} was turned away; all places are in use");
            continue;
        };
        let (what, serving) = (Arc::clone(&what), serve(stream, peer, Arc::clone(&place)));
        tokio::spawn(async move {
            let served = tokio::select! {
                biased;
                served = serving => served,
                () = place.put_out() => Err(io::Error::other("made room for a new connection")),
            };
            if let Err(error) = served {
                log::debug!("{what}: {peer}: {error}");
            }
        });
    }
}

impl Callers {
    pub fn new(capacity: Capacity) -> Self {
        let table = Arc::default();
        Self { capacity, table }
    }

    /// A place for a connection from `peer`; `None` where all of them are in use.
    pub fn enter(&self, peer: IpAddr) -> Option<Place> {
        let mut table = self.table();
        if table.places.len() >= self.capacity.connections {
            let victim = table.victim()?;
            let put_out = table.places.remove(&victim)?.put_out;
            put_out.notify_one();
        }
        let id = table.next_event();
        let put_out = Arc::new(Notify::new());
        let entry = Entry {
            peer,
            is_in_use: false,
            last_event: id,
            put_out: Arc::clone(&put_out),
        };
        table.places.insert(id, entry);
        let callers = self.clone();
        Some(Place {
            callers,
            id,
            put_out,
        })
    }

    fn table(&self) -> MutexGuard<'_, Table> {
        self.table.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Table {
    fn next_event(&mut self) -> u64 {
        self.events += 1;
        self.events
    }

    fn victim(&self) -> Option<u64> {
        let mut counts = HashMap::new();
        for entry in self.places.values() {
            *counts.entry(entry.peer).or_insert(0_usize) += 1;
        }
        let silent = self.places.iter().filter(|(_, entry)| !entry.is_in_use);
        let rank = |entry: &Entry| {
            (
                counts.get(&entry.peer).copied(),
                u64::MAX - entry.last_event,
            )
        };
        silent
            .max_by_key(|(_, entry)| rank(entry))
            .map(|(&id, _)| id)
    }
}

impl Place {
    /// Returns when the connection has to make room.
    pub async fn put_out(&self) {
        self.put_out.notified().await;
    }

    /// Keeps the place while it is in use; `false` where the computer has too many of those already.
    pub fn begin_use(&self) -> bool {
        let mut table = self.callers.table();
        let Some(peer) = table.places.get(&self.id).map(|entry| entry.peer) else {
            return false;
        };
        let is_live = |entry: &&Entry| entry.is_in_use && entry.peer == peer;
        let in_use = table.places.values().filter(is_live).count();
        let has_room = in_use < self.callers.capacity.in_use_per_peer;
        if has_room && let Some(entry) = table.places.get_mut(&self.id) {
            entry.is_in_use = true;
        }
        has_room
    }

    /// From now on the connection is idle.
    pub fn end_use(&self) {
        let mut table = self.callers.table();
        let last_event = table.next_event();
        if let Some(entry) = table.places.get_mut(&self.id) {
            entry.is_in_use = false;
            entry.last_event = last_event;
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.callers.table().places.remove(&self.id);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const LAB: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 1));
    const STRANGER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 9));

    /// Whether the connection has to make room. The notification is consumed, so this can be asked only once.
    fn is_out(place: &Place) -> bool {
        let waiting = std::pin::pin!(place.put_out());
        let mut context = std::task::Context::from_waker(std::task::Waker::noop());
        waiting.poll(&mut context).is_ready()
    }

    #[test]
    fn the_longest_idle_of_the_most_frequent_peer_makes_room() {
        let callers = Callers::new(Capacity::CALLS);
        let own = callers.enter(LAB).unwrap();
        let strangers: Vec<Place> = (1..Capacity::CALLS.connections)
            .map(|_| callers.enter(STRANGER).unwrap())
            .collect();
        assert!(strangers[0].begin_use());
        strangers[0].end_use();
        let _new = callers.enter(LAB).unwrap();
        let out: Vec<usize> = (0..strangers.len())
            .filter(|&index| is_out(&strangers[index]))
            .collect();
        assert_eq!(out, [1]);
        assert!(!is_out(&own));
    }

    #[test]
    fn what_is_in_use_keeps_its_place_and_is_counted_for_each_peer() {
        let Capacity {
            connections,
            in_use_per_peer,
        } = Capacity::CALLS;
        let callers = Callers::new(Capacity::CALLS);
        let strangers: Vec<Place> = (0..connections)
            .map(|_| callers.enter(STRANGER).unwrap())
            .collect();
        let in_use = strangers.iter().filter(|place| place.begin_use()).count();
        assert_eq!(in_use, in_use_per_peer);
        for _ in 0..2 * connections {
            assert!(callers.enter(LAB).unwrap().begin_use());
        }
        assert_eq!(strangers.iter().filter(|place| is_out(place)).count(), 1);
    }

    #[test]
    fn nobody_enters_where_all_are_in_use() {
        let callers = Callers::new(Capacity::CALLS);
        let peers =
            (0..Capacity::CALLS.connections).map(|index| IpAddr::from([10, 0, 1, index as u8]));
        let places: Vec<Place> = peers.map(|peer| callers.enter(peer).unwrap()).collect();
        assert!(places.iter().all(Place::begin_use));
        assert!(callers.enter(LAB).is_none());
        drop(places);
        assert!(callers.enter(LAB).is_some());
    }
}
