//! A topic that this node publishes, as its subscribers see it.

use crate::callers::Place;
use crate::message_kind::MessageKind;
use crate::tcpros::{is_unreachable, set_silence_max};
use std::collections::{HashMap, VecDeque};
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::ReadHalf;
use tokio::sync::{Notify, watch};
use tokio::time::timeout;

/// How long a subscriber may take for one message while its computer answers (a frozen rviz, say). After that its connection
/// is closed; it connects again when it goes on.
const WRITE_MAX: Duration = Duration::from_secs(5);

/// Whether late subscribers get the last message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Latch {
    /// They wait for the next one.
    No,
    /// They get it at once, and their header says so: rosbag keeps it for replays that begin later.
    Yes,
}

/// A topic and who listens to it.
pub(crate) struct Publication {
    /// Resolved name of the topic.
    pub topic: String,
    /// Its message's type, checksum and definition.
    pub kind: MessageKind,
    latch: Latch,
    /// Messages kept for a slow subscriber.
    queue: usize,
    /// Silence of a subscriber's computer after which its connection is closed.
    silence_max: Duration,
    state: Mutex<State>,
    /// Notified when a subscriber comes or goes.
    changes: watch::Sender<()>,
}

#[derive(Default)]
struct State {
    links: HashMap<u64, Arc<Link>>,
    /// The last message, for those who come late.
    last: Option<Arc<[u8]>>,
    /// Whether the subscriber who left last did so because its computer said nothing any more.
    is_last_unreachable: bool,
}

/// A subscriber's connection.
struct Link {
    /// Name of the node.
    subscriber: String,
    waiting: Mutex<VecDeque<Arc<[u8]>>>,
    news: Notify,
}

impl Publication {
    pub fn new(
        topic: String,
        kind: MessageKind,
        queue: usize,
        latch: Latch,
        silence_max: Duration,
    ) -> Self {
        Self {
            topic,
            kind,
            latch,
            queue: queue.max(1),
            silence_max,
            state: Mutex::default(),
            changes: watch::Sender::new(()),
        }
    }

    /// Queues a message with its length before it.
    pub fn send(&self, bytes: Arc<[u8]>) {
        let mut state = self.state();
        for link in state.links.values() {
            link.push(Arc::clone(&bytes), self.queue);
        }
        if self.latch == Latch::Yes {
            state.last = Some(bytes);
        }
    }

    /// Whether a message would be kept or sent.
    pub fn is_wanted(&self) -> bool {
        self.latch == Latch::Yes || self.is_subscribed()
    }

    pub fn is_subscribed(&self) -> bool {
        !self.state().links.is_empty()
    }

    /// Names of the nodes that are connected now.
    pub fn subscribers(&self) -> Vec<String> {
        let state = self.state();
        state
            .links
            .values()
            .map(|link| link.subscriber.clone())
            .collect()
    }

    /// Whether the subscriber who left last has been unreachable for a while; it did not go just now.
    pub fn is_last_unreachable(&self) -> bool {
        self.state().is_last_unreachable
    }

    /// Notified when a subscriber comes or goes.
    pub fn changes(&self) -> watch::Receiver<()> {
        self.changes.subscribe()
    }

    /// Whether all that was sent has been handed to the system.
    pub fn is_flushed(&self) -> bool {
        self.state()
            .links
            .values()
            .all(|link| link.waiting().is_empty())
    }

    /// Sends the topic to a subscriber with the connection header `fields`, until one end closes the connection.
    pub async fn serve(
        &self,
        stream: &mut TcpStream,
        fields: &HashMap<String, String>,
        place: &Place,
    ) -> io::Result<()> {
        let latching = if self.latch == Latch::Yes { "1" } else { "0" };
        let accepted = self.kind.header(&self.topic, ("latching", latching));
        set_silence_max(stream, self.silence_max)?;
        timeout(WRITE_MAX, stream.write_all(&accepted)).await??;
        if !place.begin_use() {
            return Err(io::Error::other("too many subscribers on that computer"));
        }
        let subscriber = fields.get("callerid").map_or("", String::as_str);
        let mut link = Listed::new(self, subscriber);
        let (mut reader, mut writer) = stream.split();
        let ended = tokio::select! {
            ended = until_closed(&mut reader) => ended,
            never = async {
                loop {
                    let bytes = link.link.next().await;
                    timeout(WRITE_MAX, writer.write_all(&bytes)).await??;
                    link.link.sent();
                }
            } => never,
        };
        link.is_unreachable = ended.as_ref().is_err_and(is_unreachable);
        ended
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Subscribers send nothing after their header.
async fn until_closed(reader: &mut ReadHalf<'_>) -> io::Result<()> {
    let mut ignored = [0; 256];
    while reader.read(&mut ignored).await? > 0 {}
    Ok(())
}

/// Lists a link among those of its publication, until dropped.
struct Listed<'a> {
    publication: &'a Publication,
    link: Arc<Link>,
    id: u64,
    /// Whether it ends because the subscriber's computer says nothing any more.
    is_unreachable: bool,
}

impl<'a> Listed<'a> {
    fn new(publication: &'a Publication, subscriber: &str) -> Self {
        static IDS: AtomicU64 = AtomicU64::new(0);
        let id = IDS.fetch_add(1, Ordering::Relaxed);
        let link = Arc::new(Link {
            subscriber: subscriber.into(),
            waiting: Mutex::default(),
            news: Notify::new(),
        });
        let mut state = publication.state();
        if let Some(last) = &state.last {
            link.push(Arc::clone(last), 1);
        }
        state.links.insert(id, Arc::clone(&link));
        drop(state);
        publication.changes.send_replace(());
        Self {
            publication,
            link,
            id,
            is_unreachable: false,
        }
    }
}

impl Drop for Listed<'_> {
    fn drop(&mut self) {
        let mut state = self.publication.state();
        state.links.remove(&self.id);
        state.is_last_unreachable = self.is_unreachable;
        drop(state);
        self.publication.changes.send_replace(());
    }
}

impl Link {
    /// Queues a message. A full queue drops its oldest message, but for the first, which is being sent.
    fn push(&self, bytes: Arc<[u8]>, queue: usize) {
        let mut waiting = self.waiting();
        if waiting.len() > queue {
            waiting.remove(1);
        }
        waiting.push_back(bytes);
        drop(waiting);
        self.news.notify_one();
    }

    /// The oldest message, as soon as there is one. It stays in the queue until [`Link::sent`].
    async fn next(&self) -> Arc<[u8]> {
        loop {
            let first = self.waiting().front().cloned();
            match first {
                Some(bytes) => return bytes,
                None => self.news.notified().await,
            }
        }
    }

    fn sent(&self) {
        self.waiting().pop_front();
    }

    fn waiting(&self) -> MutexGuard<'_, VecDeque<Arc<[u8]>>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::tcpros::PROMPT;

    fn publication(latch: Latch) -> Publication {
        let kind = MessageKind::of::<msg::std_msgs::Bool>();
        Publication::new("/topic".into(), kind, 2, latch, PROMPT)
    }

    #[tokio::test]
    async fn the_oldest_go_but_for_the_one_that_is_being_sent() {
        let publication = publication(Latch::No);
        let listed = Listed::new(&publication, "/reader");
        for number in 0..9_u8 {
            publication.send([number].into());
        }
        let mut sent = Vec::new();
        while !publication.is_flushed() {
            sent.push(listed.link.next().await[0]);
            listed.link.sent();
        }
        assert_eq!(sent, [0, 7, 8]);
        assert_eq!(publication.subscribers(), ["/reader"]);
        drop(listed);
        assert!(!publication.is_subscribed());
    }

    #[tokio::test]
    async fn late_subscribers_get_the_last_message_once() {
        let publication = publication(Latch::Yes);
        publication.send([7].into());
        let listed = Listed::new(&publication, "/late");
        assert_eq!(*listed.link.next().await, [7]);
        listed.link.sent();
        assert!(publication.is_flushed());
    }
}
