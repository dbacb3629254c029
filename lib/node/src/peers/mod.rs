//! Watches the other nodes: which of them do not answer, and whose clock is skewed against ours.

mod report;

pub use report::{PeerClock, Source, Unreachable};

use crate::clock_skew::{Lags, offset};
use crate::node::Node;
use crate::xmlrpc::call_ros;
use crate::{clock, master, names, xmlrpc};
use msg::Time;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::task::JoinSet;

/// Pause between two rounds of questions.
const PERIOD: Duration = Duration::from_secs(2);
/// How long a node has to answer.
const DEADLINE: Duration = Duration::from_secs(1);
/// Round trips of which the shortest counts.
const ROUND_TRIPS_KEPT: usize = 5;

/// What is known of the other nodes. Clones share it.
#[derive(Clone)]
pub struct Peers {
    known: Arc<Mutex<Known>>,
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
    pub fn peers(&self) -> Peers {
        let peers = Peers {
            known: Arc::default(),
        };
        let asking = peers.clone();
        tokio::spawn(async move {
            loop {
                // Without a master those known are asked again: it may be the only one that is gone.
                if let Err(error) = learn(&asking.known).await {
                    log::debug!("the nodes of the graph are not known: {error}");
                }
                asking.ask_all().await;
                tokio::time::sleep(PERIOD).await;
            }
        });
        peers
    }
}

impl Peers {
    /// Takes the stamp of a message that arrived now, straight from the clock of `source`.
    pub fn note(&self, source: Source, stamp: Time) {
        if stamp.nanos() == 0 {
            return; // not stamped
        }
        let lag_s = (clock::now() - stamp).seconds();
        lock(&self.known)
            .lags
            .entry(source)
            .or_default()
            .note(lag_s, Instant::now());
    }

    /// Asks all known nodes now; takes a second where one does not answer.
    pub fn ask(&self) {
        master::blocking(self.ask_all());
    }

    async fn ask_all(&self) {
        let nodes = lock(&self.known).nodes.clone();
        let mut questions = JoinSet::new();
        for (name, peer) in nodes {
            questions.spawn(async move {
                let begun = Instant::now();
                let answer = call_ros(&peer.uri, "getPid", &[names::own().into()], DEADLINE).await;
                (name, answer.map(|_| begun.elapsed()))
            });
        }
        let answers = questions.join_all().await;
        let mut known = lock(&self.known);
        for (name, answer) in answers {
            if let Some(peer) = known.nodes.get_mut(&name) {
                peer.note(answer);
            }
        }
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

/// Asks the master for all nodes but this one, and where they are.
async fn learn(known: &Mutex<Known>) -> std::io::Result<()> {
    let [published, read] = master::topics().await?;
    let mut names: BTreeSet<String> = published
        .values()
        .chain(read.values())
        .flatten()
        .cloned()
        .collect();
    names.remove(names::own());
    let mut uris = BTreeMap::new();
    for name in names {
        if let Ok(uri) = master::lookup_node(&name).await {
            uris.insert(name, uri);
        }
    }
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
    known.publishers = published;
    Ok(())
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
