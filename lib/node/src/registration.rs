//! What the master knows of this node. It is told again when it was restarted.

use crate::publication::Publication;
use crate::subscription::Subscription;
use crate::{logging, master, names};
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

/// Pause between two looks whether the master knows this node.
const MASTER_PERIOD: Duration = Duration::from_secs(2);
/// Pause between two attempts to tell it something.
const RETRY: Duration = Duration::from_millis(500);

/// Something that this node has registered with the master.
#[derive(Clone)]
pub(crate) enum Entry {
    Publication(Arc<Publication>),
    /// A subscription to this topic, registered while the subscription is held.
    Subscription(String, Weak<Subscription>),
    /// A service and where it is.
    Service {
        name: String,
        uri: String,
    },
}

type Restore = Box<dyn Fn() + Send>;

/// All entries of this node.
pub(crate) struct Registrations {
    core: Arc<Core>,
}

struct Core {
    /// URI of this node's slave API, which the master hands on to other nodes.
    uri: String,
    entries: Mutex<Vec<Listed>>,
    news: Notify,
    /// Called after the master was restarted: writes the parameters in force again.
    restore: Mutex<Option<Restore>>,
}

struct Listed {
    entry: Entry,
    /// Whether the master has acknowledged this entry.
    is_told: bool,
}

impl Registrations {
    /// Without entries, for a node whose slave API is at `uri`.
    pub fn start(uri: String) -> Self {
        let core = Arc::new(Core {
            uri,
            entries: Mutex::default(),
            news: Notify::new(),
            restore: Mutex::default(),
        });
        tokio::spawn(Arc::clone(&core).keep());
        Self { core }
    }

    pub fn add(&self, entry: Entry) {
        let is_told = false;
        lock(&self.core.entries).push(Listed { entry, is_told });
        self.core.news.notify_one();
    }

    /// Calls `restore` when the master has forgotten this node's parameters.
    pub fn on_restart(&self, restore: impl Fn() + Send + 'static) {
        *lock(&self.core.restore) = Some(Box::new(restore));
    }

    /// Unregisters all entries. Those that the master has not acknowledged by the deadline are left registered.
    pub async fn withdraw(&self, deadline: Duration) {
        let entries = std::mem::take(&mut *lock(&self.core.entries));
        let mut calls = JoinSet::new();
        for listed in entries {
            let core = Arc::clone(&self.core);
            calls.spawn(async move { core.withdraw(&listed.entry).await });
        }
        if timeout(deadline, calls.join_all()).await.is_err() {
            logging::show(
                log::Level::Warn,
                "the ROS master does not answer; leaving without unregistering",
            );
        }
    }
}

impl Core {
    async fn keep(self: Arc<Self>) {
        let mut is_out_of_reach = false;
        loop {
            let news = self.news.notified();
            self.tell_all().await;
            self.withdraw_dropped().await;
            // Returns early where there is news.
            if timeout(MASTER_PERIOD, news).await.is_ok() {
                continue;
            }
            match master::lookup_node(names::own()).await {
                // Also where another node took the name over.
                Ok(_) => {
                    if std::mem::take(&mut is_out_of_reach) {
                        log::info!("the ROS master answers again");
                    }
                }
                Err(error) if is_refusal(&error) => {
                    log::warn!("the ROS master was restarted; registering again");
                    lock(&self.entries)
                        .iter_mut()
                        .for_each(|listed| listed.is_told = false);
                    let restore = || lock(&self.restore).iter().for_each(|restore| restore());
                    tokio::task::block_in_place(restore);
                }
                Err(_) => {
                    if !std::mem::replace(&mut is_out_of_reach, true) {
                        log::warn!("the ROS master does not answer; links that exist go on");
                    }
                }
            }
        }
    }

    /// Registers what the master does not know yet, in the order in which it was added.
    async fn tell_all(&self) {
        loop {
            let next = {
                let entries = lock(&self.entries);
                let mut untold = entries
                    .iter()
                    .enumerate()
                    .filter(|(_, listed)| !listed.is_told);
                untold
                    .next()
                    .map(|(index, listed)| (index, listed.entry.clone()))
            };
            let Some((index, entry)) = next else {
                return;
            };
            match self.register(&entry).await {
                Ok(()) => {
                    // Only this task takes entries away, but for the end of the node.
                    if let Some(listed) = lock(&self.entries).get_mut(index) {
                        listed.is_told = true;
                    }
                }
                Err(error) => {
                    log::warn!("the ROS master was not told of {}: {error}", entry.name());
                    sleep(RETRY).await;
                }
            }
        }
    }

    /// Unregisters subscriptions that nobody in this process holds any more.
    async fn withdraw_dropped(&self) {
        let dropped: Vec<Entry> = {
            let mut entries = lock(&self.entries);
            let (dropped, kept) = std::mem::take(&mut *entries)
                .into_iter()
                .partition(|listed| listed.entry.is_dropped());
            *entries = kept;
            let is_read = |dropped: &Listed| {
                entries.iter().any(|listed| match &listed.entry {
                    Entry::Subscription(topic, _) => topic == dropped.entry.name(),
                    _ => false,
                })
            };
            let dropped: Vec<Listed> = dropped;
            let unread = dropped.into_iter().filter(|dropped| !is_read(dropped));
            unread.map(|listed| listed.entry).collect()
        };
        for entry in dropped {
            if let Err(error) = self.withdraw(&entry).await {
                log::debug!("{} stays with the master: {error}", entry.name());
            }
        }
    }

    async fn register(&self, entry: &Entry) -> io::Result<()> {
        let uri = &self.uri[..];
        match entry {
            Entry::Publication(publication) => {
                let (topic, kind) = (&publication.topic[..], &publication.kind.name[..]);
                let arguments = [topic.into(), kind.into(), uri.into()];
                master::call("registerPublisher", &arguments).await?;
            }
            Entry::Subscription(_, subscription) => {
                let Some(subscription) = subscription.upgrade() else {
                    return Ok(());
                };
                let (topic, kind) = (&subscription.topic[..], &subscription.kind.name[..]);
                let arguments = [topic.into(), kind.into(), uri.into()];
                let publishers = master::call("registerSubscriber", &arguments).await?;
                subscription.set_publishers(publishers.into_texts());
            }
            Entry::Service {
                name,
                uri: service_uri,
            } => {
                let arguments = [name[..].into(), service_uri[..].into(), uri.into()];
                master::call("registerService", &arguments).await?;
            }
        }
        Ok(())
    }

    async fn withdraw(&self, entry: &Entry) -> io::Result<()> {
        let (method, uri) = match entry {
            Entry::Publication(_) => ("unregisterPublisher", &self.uri),
            Entry::Subscription(..) => ("unregisterSubscriber", &self.uri),
            Entry::Service { uri, .. } => ("unregisterService", uri),
        };
        let arguments = [entry.name().into(), uri[..].into()];
        master::call(method, &arguments).await.map(drop)
    }
}

impl Entry {
    /// Name of the topic or service.
    fn name(&self) -> &str {
        match self {
            Self::Publication(publication) => &publication.topic,
            Self::Subscription(topic, _) => topic,
            Self::Service { name, .. } => name,
        }
    }

    fn is_dropped(&self) -> bool {
        matches!(self, Self::Subscription(_, subscription) if subscription.strong_count() == 0)
    }
}

/// Whether the master answered that it does not know this node; `false` also where it did not answer.
fn is_refusal(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::Other
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
