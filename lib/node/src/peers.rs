//! The other nodes: which do not answer, and whose clock is not in step with ours.

use crate::node::Node;
use crate::offset::{ClockOffset, Lags, offset};
use crate::{environment, xmlrpc};
use rosrust::Time;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Pause between two rounds of questions.
const PERIOD: Duration = Duration::from_secs(2);
/// How long a node, or the master, has to answer.
const DEADLINE: Duration = Duration::from_secs(1);
/// Round trips of which the shortest counts.
const ROUND_TRIPS_KEPT: usize = 5;

/// What is known of the other nodes. Clones share it.
#[derive(Clone)]
pub struct Peers {
    known: Arc<Mutex<Known>>,
}

/// Whose stamp it is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// The node of this name.
    Node(String),
    /// Whoever publishes this topic.
    Topic(String),
}

/// A node that does not answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Unreachable {
    /// Name of the node.
    pub node: String,
    /// Where the master says that it is; empty where it does not say.
    pub host: String,
    /// What happened instead.
    pub reason: String,
}

/// The clock of the computer that a node runs on.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerClock {
    /// Whose stamps were looked at.
    pub source: Source,
    /// Name of the node.
    pub node: String,
    /// Its computer's name or address, where known.
    pub host: String,
    /// How far its clock is from ours.
    pub offset: ClockOffset,
}

#[derive(Default)]
struct Known {
    nodes: BTreeMap<String, Peer>,
    /// Nodes by the topics that they publish.
    publishers: BTreeMap<String, Vec<String>>,
    lags: BTreeMap<Source, Lags>,
}

#[derive(Debug, Default, Clone)]
struct Peer {
    uri: String,
    round_trips: VecDeque<Duration>,
    failure: Option<String>,
}

impl Node {
    /// Starts to ask the other nodes every two seconds whether they are there. Call it once; clone the result.
    pub fn peers(&self) -> std::io::Result<Peers> {
        let peers = Peers {
            known: Arc::default(),
        };
        let known = Arc::clone(&peers.known);
        std::thread::Builder::new()
            .name("peers".into())
            .spawn(move || {
                while rosrust::is_ok() {
                    ask_all(&known);
                    std::thread::sleep(PERIOD);
                }
            })?;
        Ok(peers)
    }
}

impl Peers {
    /// Takes the stamp of a message that arrived now, straight from the clock of `source`.
    pub fn note(&self, source: Source, stamp: Time) {
        if stamp.nanos() == 0 {
            return; // not stamped
        }
        let lag_s = (rosrust::now() - stamp).seconds();
        lock(&self.known)
            .lags
            .entry(source)
            .or_default()
            .note(lag_s, Instant::now());
    }

    /// Asks all known nodes now; takes a second where one does not answer.
    pub fn ask(&self) {
        ask_known(&self.known);
    }

    /// The nodes that the master knows and that did not answer when they were last asked.
    pub fn unreachable(&self) -> Vec<Unreachable> {
        let known = lock(&self.known);
        let failed = known.nodes.iter().filter_map(|(node, peer)| {
            Some(Unreachable {
                node: node.clone(),
                host: peer.host(),
                reason: peer.failure.clone()?,
            })
        });
        failed.collect()
    }

    /// The clocks of all sources that were heard of in the last seconds.
    pub fn clocks(&self) -> Vec<PeerClock> {
        let known = lock(&self.known);
        let now = Instant::now();
        let clock = |(source, lags): (&Source, &Lags)| {
            let node = known.name_of(source);
            let peer = known.nodes.get(&node);
            let round_trip = peer.and_then(|peer| peer.round_trips.iter().min().copied());
            Some(PeerClock {
                source: source.clone(),
                offset: offset(lags.least_s(now)?, round_trip),
                host: peer.map(Peer::host).unwrap_or_default(),
                node,
            })
        };
        known.lags.iter().filter_map(clock).collect()
    }
}

impl Known {
    fn name_of(&self, source: &Source) -> String {
        match source {
            Source::Node(name) => name.clone(),
            Source::Topic(topic) => self
                .publishers
                .get(topic)
                .and_then(|nodes| nodes.first().cloned())
                .unwrap_or_else(|| format!("whoever publishes {topic}")),
        }
    }
}

impl Peer {
    fn host(&self) -> String {
        let host = xmlrpc::authority(&self.uri).and_then(|authority| authority.rsplit_once(':'));
        host.map(|(host, _)| host.into()).unwrap_or_default()
    }

    fn note(&mut self, answer: std::io::Result<Duration>) {
        match answer {
            Ok(round_trip) => {
                self.failure = None;
                self.round_trips.push_back(round_trip);
                if self.round_trips.len() > ROUND_TRIPS_KEPT {
                    self.round_trips.pop_front();
                }
            }
            Err(error) => self.failure = Some(error.to_string()),
        }
    }
}

impl PeerClock {
    /// Whether it is ahead of this computer's.
    pub fn is_ahead(&self) -> bool {
        self.offset.offset_s > 0.0
    }
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { node, host, reason } = self;
        match &host[..] {
            "" => write!(f, "{node} does not answer ({reason})"),
            _ => write!(f, "{node} at {host} does not answer ({reason})"),
        }
    }
}

impl fmt::Display for PeerClock {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            node, host, offset, ..
        } = self;
        let sense = if offset.offset_s < 0.0 {
            "behind"
        } else {
            "ahead of"
        };
        let at = if host.is_empty() {
            String::new()
        } else {
            format!(" at {host}")
        };
        write!(
            f,
            "the clock of {node}{at} is {:.0} ms {sense} this computer's (± {:.0} ms)",
            offset.offset_s.abs() * 1e3,
            offset.uncertainty_s * 1e3
        )
    }
}

/// One round: who is there, and do they answer?
fn ask_all(known: &Mutex<Known>) {
    // Without a master those known are asked again: it may be the only one that is gone.
    if environment::check_master().is_ok() {
        learn(known, &environment::master_uri());
    }
    ask_known(known);
}

fn ask_known(known: &Mutex<Known>) {
    let asked = lock(known).nodes.clone();
    let answers = std::thread::scope(|scope| {
        let threads: Vec<_> = asked
            .into_iter()
            .map(|(name, peer)| {
                scope.spawn(move || {
                    let answer = xmlrpc::ping(&peer.uri, DEADLINE);
                    (name, answer)
                })
            })
            .collect();
        let join = |thread: std::thread::ScopedJoinHandle<'_, _>| thread.join().ok();
        threads.into_iter().filter_map(join).collect::<Vec<_>>()
    });
    let mut known = lock(known);
    for (name, answer) in answers {
        if let Some(peer) = known.nodes.get_mut(&name) {
            peer.note(answer);
        }
    }
}

/// Asks the master for all nodes but this one, and where they are.
fn learn(known: &Mutex<Known>, master_uri: &str) {
    let Ok(state) = rosrust::state() else {
        return;
    };
    let own_name = rosrust::name();
    let topics = || state.publishers.iter().chain(&state.subscribers);
    let mut names: BTreeSet<String> = topics()
        .flat_map(|topic| topic.connections.iter().cloned())
        .collect();
    names.remove(&own_name);
    let uris: BTreeMap<_, _> = names
        .into_iter()
        .filter_map(|name| {
            let uri = xmlrpc::lookup_node(master_uri, &name, DEADLINE).ok()?;
            Some((name, uri))
        })
        .collect();
    let (mut known, now) = (lock(known), Instant::now());
    known.lags.retain(|_, lags| lags.least_s(now).is_some());
    known.nodes.retain(|name, _| uris.contains_key(name));
    for (name, uri) in uris {
        let peer = known.nodes.entry(name).or_default();
        if peer.uri != uri {
            // Another process of this name, perhaps elsewhere.
            *peer = Peer {
                uri,
                ..Default::default()
            };
        }
    }
    known.publishers = state
        .publishers
        .into_iter()
        .map(|topic| (topic.name, topic.connections))
        .collect();
}

fn lock(known: &Mutex<Known>) -> MutexGuard<'_, Known> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn troubles_name_the_node_its_host_and_the_number() {
        let mut peer = Peer {
            uri: "http://10.0.0.2:4711/".into(),
            ..Default::default()
        };
        peer.note(Err(std::io::ErrorKind::TimedOut.into()));
        let unreachable = Unreachable {
            node: "/wrist_rotator".into(),
            host: peer.host(),
            reason: peer.failure.clone().unwrap_or_default(),
        };
        assert_eq!(
            unreachable.to_string(),
            "/wrist_rotator at 10.0.0.2 does not answer (timed out)"
        );
        peer.note(Ok(Duration::from_millis(2)));
        assert_eq!(peer.failure, None);
        let clock = PeerClock {
            source: Source::Node("/robot".into()),
            node: "/robot".into(),
            host: "10.0.0.1".into(),
            offset: offset(0.151, Some(Duration::from_millis(2))),
        };
        assert_eq!(
            clock.to_string(),
            "the clock of /robot at 10.0.0.1 is 150 ms behind this computer's (± 1 ms)"
        );
    }

    #[test]
    fn a_topic_stands_for_who_publishes_it() {
        let mut known = Known::default();
        let source = Source::Topic("/robot/joint_states".into());
        assert!(known.name_of(&source).contains("/robot/joint_states"));
        let publishers = vec!["/baxter".to_string()];
        known
            .publishers
            .insert("/robot/joint_states".into(), publishers);
        assert_eq!(known.name_of(&source), "/baxter");
    }
}
