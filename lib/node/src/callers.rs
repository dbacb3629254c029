//! The connections that a service has at a time, and which of them make room for a new one.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::oneshot;

/// Connections of a service at a time.
const CALLERS_MAX: usize = 64;
/// Requests of one computer that are worked on at a time: others find room whatever it asks for.
const WORKING_MAX_PER_PEER: usize = 16;

/// The callers of a service. Clones share them.
///
/// Only those whose request is worked on keep their place for sure. Where all places are taken, the computer with the most
/// connections loses the one that has been silent longest, be it that its header has not come or that it keeps a
/// persistent connection.
#[derive(Clone, Default)]
pub(crate) struct Callers {
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
    is_working: bool,
    /// Of the table's events, the last that concerned this entry.
    last_event: u64,
    /// Dropped to put the connection out.
    _keep: oneshot::Sender<()>,
}

/// A connection among the callers, until dropped.
pub(crate) struct Place {
    callers: Callers,
    id: u64,
    /// Ends when the connection has to make room.
    pub put_out: oneshot::Receiver<()>,
}

impl Callers {
    /// A place for a connection from `peer`; `None` where requests are worked on in all of them.
    pub fn enter(&self, peer: IpAddr) -> Option<Place> {
        let mut table = self.table();
        if table.places.len() >= CALLERS_MAX {
            let victim = table.victim()?;
            table.places.remove(&victim);
        }
        let id = table.next_event();
        let (keep, put_out) = oneshot::channel();
        let entry = Entry {
            peer,
            is_working: false,
            last_event: id,
            _keep: keep,
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
        let silent = self.places.iter().filter(|(_, entry)| !entry.is_working);
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
    /// Keeps the place while a request is worked on; `false` where the computer has too many of those already.
    pub fn begin_work(&self) -> bool {
        let mut table = self.callers.table();
        let Some(peer) = table.places.get(&self.id).map(|entry| entry.peer) else {
            return false;
        };
        let is_live = |entry: &&Entry| entry.is_working && entry.peer == peer;
        let has_room = table.places.values().filter(is_live).count() < WORKING_MAX_PER_PEER;
        if has_room && let Some(entry) = table.places.get_mut(&self.id) {
            entry.is_working = true;
        }
        has_room
    }

    /// From now on the connection is silent.
    pub fn end_work(&self) {
        let mut table = self.callers.table();
        let last_event = table.next_event();
        if let Some(entry) = table.places.get_mut(&self.id) {
            entry.is_working = false;
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

    fn is_out(place: &mut Place) -> bool {
        !matches!(
            place.put_out.try_recv(),
            Err(oneshot::error::TryRecvError::Empty)
        )
    }

    #[test]
    fn the_longest_silent_of_the_most_frequent_peer_makes_room() {
        let callers = Callers::default();
        let mut own = callers.enter(LAB).unwrap();
        let mut strangers: Vec<Place> = (1..CALLERS_MAX)
            .map(|_| callers.enter(STRANGER).unwrap())
            .collect();
        assert!(strangers[0].begin_work());
        strangers[0].end_work();
        let _new = callers.enter(LAB).unwrap();
        let out: Vec<usize> = (0..strangers.len())
            .filter(|&index| is_out(&mut strangers[index]))
            .collect();
        assert_eq!(out, [1]);
        assert!(!is_out(&mut own));
    }

    #[test]
    fn work_keeps_its_place_and_is_counted_for_each_peer() {
        let callers = Callers::default();
        let mut strangers: Vec<Place> = (0..CALLERS_MAX)
            .map(|_| callers.enter(STRANGER).unwrap())
            .collect();
        let working = strangers.iter().filter(|place| place.begin_work()).count();
        assert_eq!(working, WORKING_MAX_PER_PEER);
        for _ in 0..2 * CALLERS_MAX {
            assert!(callers.enter(LAB).unwrap().begin_work());
        }
        let out = strangers.iter_mut().map(is_out).filter(|out| *out).count();
        assert_eq!(out, 1);
    }

    #[test]
    fn nobody_enters_where_all_work() {
        let callers = Callers::default();
        let peers = (0..CALLERS_MAX).map(|index| IpAddr::from([10, 0, 1, index as u8]));
        let places: Vec<Place> = peers.map(|peer| callers.enter(peer).unwrap()).collect();
        assert!(places.iter().all(Place::begin_work));
        assert!(callers.enter(LAB).is_none());
        drop(places);
        assert!(callers.enter(LAB).is_some());
    }
}
