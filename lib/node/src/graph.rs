//! This process in the ROS graph: what it publishes, reads and offers, and what other nodes ask it:
//! <https://wiki.ros.org/ROS/Slave_API>.

use crate::callers::{Capacity, Place, accept_all, listen};
use crate::publication::Publication;
use crate::registration::{Entry, Registrations};
use crate::service_server::{Handler, Server};
use crate::subscription::Subscription;
use crate::tcpros::{header, read_header, set_options};
use crate::xmlrpc::{self, Value};
use crate::{environment, names, shutdown};
use msg::service::Service;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep, timeout};

/// How long a subscriber may take for its header.
const GREETING_MAX: Duration = Duration::from_secs(2);
/// Pause between looks whether all messages are out.
const FLUSH_PERIOD: Duration = Duration::from_millis(5);

/// This process in the graph.
pub(crate) struct Graph {
    /// This computer's name or address, as others know it.
    host: String,
    /// TCP port from which topics are sent.
    port: u16,
    links: Mutex<Links>,
    pub registrations: Registrations,
}

#[derive(Default)]
struct Links {
    publications: Vec<Arc<Publication>>,
    subscriptions: Vec<Weak<Subscription>>,
}

impl Graph {
    /// Opens the ports for subscribers and for the slave API.
    ///
    /// # Errors
    /// Where no ports can be had.
    pub fn start(host: String) -> io::Result<Arc<Self>> {
        let (questions, subscribers) = (listen(&host)?, listen(&host)?);
        let uri = format!("http://{host}:{}/", questions.local_addr()?.port());
        let graph = Arc::new(Self {
            port: subscribers.local_addr()?.port(),
            host,
            links: Mutex::default(),
            registrations: Registrations::start(uri),
        });
        let sending = Arc::clone(&graph);
        let serve = move |stream, peer, place: Arc<Place>| {
            let graph = Arc::clone(&sending);
            async move { graph.serve_subscriber(stream, peer, &place).await }
        };
        let what = "subscribers".to_owned();
        tokio::spawn(accept_all(subscribers, Capacity::SUBSCRIBERS, what, serve));
        let asked = Arc::clone(&graph);
        let respond = move |method: &str, arguments| asked.respond(method, arguments);
        tokio::spawn(xmlrpc::serve(questions, Arc::new(respond)));
        Ok(graph)
    }

    /// Publishes a topic from now on.
    ///
    /// # Errors
    /// Where this process publishes it already.
    pub fn publish(&self, publication: Publication) -> anyhow::Result<Arc<Publication>> {
        let publication = Arc::new(publication);
        let mut links = self.links();
        let topic = &publication.topic;
        let is_new = !links.publications.iter().any(|other| other.topic == *topic);
        anyhow::ensure!(is_new, "this node publishes {topic} already");
        links.publications.push(Arc::clone(&publication));
        drop(links);
        let entry = Entry::Publication(Arc::clone(&publication));
        self.registrations.add(entry);
        Ok(publication)
    }

    /// Reads a topic while the subscription is held.
    pub fn subscribe(&self, subscription: &Arc<Subscription>) {
        let mut links = self.links();
        links.subscriptions.retain(|other| other.strong_count() > 0);
        links.subscriptions.push(Arc::downgrade(subscription));
        drop(links);
        let entry = Entry::Subscription(subscription.topic.clone(), Arc::downgrade(subscription));
        self.registrations.add(entry);
    }

    /// Offers the service `name`, resolved, until the server is dropped.
    ///
    /// # Errors
    /// Where no port can be had.
    pub fn serve<S: Service>(&self, name: String, handler: impl Handler<S>) -> io::Result<Server> {
        let server = Server::start(&name, &self.host, Arc::new(handler))?;
        let uri = format!("rosrpc://{}:{}", self.host, server.port());
        self.registrations.add(Entry::Service { name, uri });
        Ok(server)
    }

    /// What this process reads.
    pub fn subscriptions(&self) -> Vec<Arc<Subscription>> {
        let links = self.links();
        links
            .subscriptions
            .iter()
            .filter_map(Weak::upgrade)
            .collect()
    }

    /// Waits until all that was published has been handed to the system.
    pub async fn flush(&self, deadline: Instant) {
        let is_flushed = || {
            self.links()
                .publications
                .iter()
                .all(|topic| topic.is_flushed())
        };
        while !is_flushed() && Instant::now() < deadline {
            sleep(FLUSH_PERIOD).await;
        }
    }

    fn links(&self) -> MutexGuard<'_, Links> {
        self.links.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn publication(&self, topic: &str) -> Option<Arc<Publication>> {
        let links = self.links();
        links
            .publications
            .iter()
            .find(|other| other.topic == topic)
            .cloned()
    }

    async fn serve_subscriber(
        &self,
        mut stream: TcpStream,
        peer: SocketAddr,
        place: &Place,
    ) -> io::Result<()> {
        set_options(&stream)?;
        let fields = timeout(GREETING_MAX, read_header(&mut stream)).await??;
        let topic = fields.get("topic").map_or("", String::as_str);
        let wanted = match self.publication(topic) {
            Some(publication) => publication.kind.check(&fields).map(|()| publication),
            None => Err(format!("{} does not publish '{topic}'", names::own())),
        };
        match wanted {
            Ok(publication) => publication.serve(&mut stream, &fields, place).await,
            Err(refusal) => {
                log::warn!("the subscriber at {peer} of {topic} was refused: {refusal}");
                let refusal = header(&[("error", &refusal)]);
                timeout(GREETING_MAX, stream.write_all(&refusal)).await?
            }
        }
    }

    /// Answers a question of the master or of another node.
    fn respond(&self, method: &str, arguments: Vec<Value>) -> Result<Value, String> {
        let text = |index: usize| arguments.get(index).and_then(Value::as_text).unwrap_or("");
        let value = match method {
            "getPid" => Value::Int(std::process::id().cast_signed()),
            "getMasterUri" => environment::master_uri()[..].into(),
            "shutdown" => {
                log::info!("told to shut down by {}: {}", text(0), text(1));
                shutdown::order();
                0.into()
            }
            "requestTopic" => match self.publication(text(1)) {
                Some(_) => [
                    Value::from("TCPROS"),
                    self.host[..].into(),
                    i32::from(self.port).into(),
                ]
                .into_iter()
                .collect(),
                None => return Ok(answer(0, "no such topic", 0.into())),
            },
            "publisherUpdate" => {
                let topic = text(1).to_owned();
                let uris = arguments
                    .into_iter()
                    .nth(2)
                    .unwrap_or(0.into())
                    .into_texts();
                let subscriptions = self.subscriptions();
                let concerned = subscriptions.iter().filter(|other| other.topic == topic);
                concerned.for_each(|subscription| subscription.set_publishers(uris.clone()));
                0.into()
            }
            "paramUpdate" => 0.into(),
            "getPublications" => {
                let links = self.links();
                let topics = links.publications.iter();
                topics
                    .map(|topic| pair(&topic.topic, &topic.kind.name))
                    .collect()
            }
            "getSubscriptions" => {
                let topics = self.subscriptions();
                topics
                    .iter()
                    .map(|topic| pair(&topic.topic, &topic.kind.name))
                    .collect()
            }
            "getBusStats" => (0..3).map(|_| Value::Array(Vec::new())).collect(),
            "getBusInfo" => self.bus_info(),
            _ => return Err(format!("a node has no method {method}")),
        };
        Ok(answer(1, "", value))
    }

    /// All connections: number, far end, direction, transport, topic, whether connected.
    fn bus_info(&self) -> Value {
        let sent = self
            .links()
            .publications
            .clone()
            .into_iter()
            .flat_map(|topic| {
                let far_ends = topic.subscribers();
                far_ends
                    .into_iter()
                    .map(move |far_end| (far_end, "o", topic.topic.clone()))
            });
        let read = self.subscriptions().into_iter().flat_map(|topic| {
            let far_ends = topic.publishers();
            far_ends
                .into_iter()
                .map(move |far_end| (far_end, "i", topic.topic.clone()))
        });
        let rows = sent.chain(read).zip(1..);
        rows.map(|((far_end, direction, topic), number)| {
            Value::Array(vec![
                number.into(),
                far_end[..].into(),
                direction.into(),
                "TCPROS".into(),
                topic[..].into(),
                1.into(),
            ])
        })
        .collect()
    }
}

fn pair(topic: &str, kind: &str) -> Value {
    Value::Array(vec![topic.into(), kind.into()])
}

fn answer(code: i32, words: &str, value: Value) -> Value {
    Value::Array(vec![code.into(), words.into(), value])
}
