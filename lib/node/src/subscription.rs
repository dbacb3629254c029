//! A topic that this node reads: a connection to each of its publishers, made again when it ends.

use crate::health::Report;
use crate::inbox::Inbox;
use crate::layout::MESSAGE_BYTES_MAX;
use crate::message_kind::MessageKind;
use crate::names;
use crate::tcpros::{read_block, read_header, set_options};
use crate::xmlrpc::{self, Value};
use std::collections::{HashMap, HashSet};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncWriteExt, BufReader};
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, timeout};

/// How long a publisher may take for each step until its first message.
const DIAL_MAX: Duration = Duration::from_millis(2500);
/// Pause between two attempts to connect to the same publisher (backoff): the first, and the longest.
const RETRY_MIN: Duration = Duration::from_millis(100);
const RETRY_MAX: Duration = Duration::from_secs(1);

/// What a subscriber may expect of its topic.
#[derive(Debug, Clone, Copy)]
pub struct Expect {
    /// Queue length: messages kept while the callback is busy. When it is full, the oldest one is dropped.
    pub queue: usize,
    /// A silence that diagnostics call a trouble; `None` where nobody need publish the topic.
    pub silence_max: Option<Duration>,
}

impl Expect {
    /// State at a high rate, of which only the newest matters.
    pub const STATE: Self = Self {
        queue: 1,
        silence_max: Some(Duration::from_secs(1)),
    };
    /// The same where messages about other things share the topic, as with joint states: in a queue of one they would push
    /// it out.
    pub const SHARED_STATE: Self = Self {
        queue: 8,
        ..Self::STATE
    };
    /// State that need not be there.
    pub const OPTIONAL_STATE: Self = Self {
        silence_max: None,
        ..Self::STATE
    };
    /// Events of which each matters.
    pub const EVENTS: Self = Self {
        queue: 64,
        silence_max: None,
    };
    /// Commands, which are silent while nothing is to be done.
    pub const COMMANDS: Self = Self::EVENTS;
    /// What is published now and then.
    pub const SPORADIC: Self = Self::EVENTS;
}

/// A topic and who publishes it.
pub(crate) struct Subscription {
    /// Resolved name of the topic.
    pub topic: String,
    pub kind: MessageKind,
    /// The topic's name as it was given.
    name: String,
    expect: Expect,
    pub inbox: Arc<Inbox>,
    state: Mutex<State>,
    /// How many publishers are connected.
    connected: watch::Sender<usize>,
}

#[derive(Default)]
struct State {
    /// URIs of those nodes that publish the topic, as the master says.
    listed: HashSet<String>,
    /// What connects to each, and reads; also to one that is listed no more, for as long as its connection lasts: a
    /// restarted master forgets publishers that are still there.
    readers: HashMap<String, JoinHandle<()>>,
    is_closed: bool,
}

impl Subscription {
    pub fn new(
        name: &str,
        topic: String,
        kind: MessageKind,
        expect: Expect,
        inbox: Arc<Inbox>,
    ) -> Self {
        Self {
            topic,
            kind,
            name: name.into(),
            expect,
            inbox,
            state: Mutex::default(),
            connected: watch::Sender::new(0),
        }
    }

    /// Connects to those that are new among the publishers at these URIs.
    pub fn set_publishers(self: &Arc<Self>, uris: Vec<String>) {
        let mut state = self.state();
        if state.is_closed {
            return;
        }
        for uri in &uris {
            let reader = || tokio::spawn(Arc::clone(self).read_always(uri.clone()));
            state.readers.entry(uri.clone()).or_insert_with(reader);
        }
        state.listed = uris.into_iter().collect();
    }

    /// Ends the subscription.
    pub fn close(&self) {
        let mut state = self.state();
        state.is_closed = true;
        state.readers.drain().for_each(|(_, reader)| reader.abort());
        self.inbox.close();
    }

    /// How many publishers are connected.
    pub fn connected(&self) -> watch::Receiver<usize> {
        self.connected.subscribe()
    }

    /// URIs of the publishers.
    pub fn publishers(&self) -> Vec<String> {
        self.state().listed.iter().cloned().collect()
    }

    pub fn report(&self) -> Report {
        let heard = self.inbox.heard();
        Report {
            topic: self.name.clone(),
            count: heard.count,
            lost: heard.lost,
            silent: heard.latest.unwrap_or(heard.begun).elapsed(),
            silence_max: self.expect.silence_max,
            publishers: *self.connected.borrow(),
        }
    }

    /// Reads from the publisher at `uri` while it is listed.
    async fn read_always(self: Arc<Self>, uri: String) {
        let (mut pause, mut last) = (RETRY_MIN, None);
        loop {
            let begun = Instant::now();
            // Without an error: the publisher closed the connection.
            if let Err(error) = self.read(&uri, &mut last).await {
                log::debug!("{} from {uri}: {error}", self.topic);
            }
            if begun.elapsed() > RETRY_MAX {
                pause = RETRY_MIN;
            }
            {
                let mut state = self.state();
                if !state.listed.contains(&uri) {
                    state.readers.remove(&uri);
                    return;
                }
            }
            sleep(pause).await;
            pause = (2 * pause).min(RETRY_MAX);
        }
    }

    /// Reads until the connection ends. A publisher that latches sends its last message again where one connects again; `last` is
    /// that message.
    async fn read(&self, uri: &str, last: &mut Option<Vec<u8>>) -> io::Result<()> {
        let (mut stream, fields) = self.dial(uri).await?;
        let publisher = fields.get("callerid").map_or(uri, String::as_str);
        let _connected = Connected::new(&self.connected);
        let latches = fields.get("latching").is_some_and(|value| value == "1");
        let mut may_repeat = latches;
        loop {
            let bytes = match read_block(&mut stream, MESSAGE_BYTES_MAX).await {
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
                bytes => bytes?,
            };
            let is_repeated = std::mem::take(&mut may_repeat) && last.as_ref() == Some(&bytes);
            if latches {
                last.get_or_insert_default().clone_from(&bytes);
            }
            if !is_repeated {
                self.inbox.put(publisher, bytes);
            }
        }
    }

    /// A connection to the publisher at `uri`, and what its header says.
    async fn dial(&self, uri: &str) -> io::Result<(BufReader<TcpStream>, HashMap<String, String>)> {
        let protocols = Value::Array(vec![Value::Array(vec!["TCPROS".into()])]);
        let arguments = [names::own().into(), self.topic[..].into(), protocols];
        let answer = xmlrpc::call_ros(uri, "requestTopic", &arguments, DIAL_MAX).await?;
        let (host, port) = match &answer.into_array().unwrap_or_default()[..] {
            [_, Value::Text(host), Value::Int(port)] => (host.clone(), *port),
            _ => return Err(io::Error::other("it offers no TCPROS")),
        };
        let port = u16::try_from(port).map_err(io::Error::other)?;
        let dialled = TcpStream::connect((&host[..], port));
        let mut stream = timeout(DIAL_MAX, dialled).await??;
        set_options(&stream)?;
        // A publisher without tcp_nodelay keeps small messages back until the one before is acknowledged.
        let introduction = self.kind.header(&self.topic, ("tcp_nodelay", "1"));
        timeout(DIAL_MAX, stream.write_all(&introduction)).await??;
        let mut stream = BufReader::new(stream);
        let fields = timeout(DIAL_MAX, read_header(&mut stream)).await??;
        if let Some(refusal) = fields.get("error") {
            return Err(io::Error::other(refusal.clone()));
        }
        if let Err(mismatch) = self.kind.check(&fields) {
            log::error!("{} of {uri} cannot be read: {mismatch}", self.topic);
            return Err(io::Error::other(mismatch));
        }
        Ok((stream, fields))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Counts a connection, until dropped.
struct Connected<'a>(&'a watch::Sender<usize>);

impl<'a> Connected<'a> {
    fn new(count: &'a watch::Sender<usize>) -> Self {
        count.send_modify(|count| *count += 1);
        Self(count)
    }
}

impl Drop for Connected<'_> {
    fn drop(&mut self) {
        self.0.send_modify(|count| *count = count.saturating_sub(1));
    }
}
