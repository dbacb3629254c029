//! What the stages publish during a scan.

use anyhow::{Context, Result, ensure};
use msg::deformable_cobot::{ObjectCloud, RegisteredCloud, View};
use node::{Expect, Node, Subscriber};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;

/// How long a stage may take to be found.
const STAGE_PATIENCE: Duration = Duration::from_secs(10);
/// How long the clouds of a scan may take to come after its answer, which has a connection of its own.
const CLOUDS_PATIENCE: Duration = Duration::from_secs(5);

/// What the stages published of one scan.
#[derive(Clone, Default)]
pub struct Recorded {
    /// Views by their index.
    pub views: BTreeMap<u32, View>,
    /// The registered cloud of all views.
    pub registered: RegisteredCloud,
    /// The object's cloud, cropped from it.
    pub object: ObjectCloud,
}

/// Scans by their id: another scan may be running when this one is asked for.
type Scans = BTreeMap<String, Recorded>;

#[derive(Default)]
struct Heard {
    scans: Mutex<Scans>,
    news: Notify,
}

/// Keeps all views and clouds that are published.
pub struct Recording {
    heard: Arc<Heard>,
    _links: [Subscriber; 3],
}

impl Recording {
    /// Subscribes to the scans' topics, and waits until they are connected.
    ///
    /// # Errors
    /// A topic has no publisher within the time limit.
    pub async fn listen(node: &Node) -> Result<Self> {
        let heard = Arc::new(Heard::default());
        let on_view = on(&heard, |scans, view: View| {
            if view.kind == View::VIEW {
                of(scans, &view.scan_id).views.insert(view.index, view);
            }
        });
        let on_registered = on(&heard, |scans, registered: RegisteredCloud| {
            let scan = of(scans, &registered.scan_id);
            scan.registered = registered;
        });
        let on_object = on(&heard, |scans, object: ObjectCloud| {
            let scan = of(scans, &object.scan_id);
            scan.object = object;
        });
        let links = [
            node.subscribe("views", Expect::EVENTS, on_view)?,
            node.subscribe("registered", Expect::EVENTS, on_registered)?,
            node.subscribe("object", Expect::EVENTS, on_object)?,
        ];
        for (link, topic) in links.iter().zip(["views", "registered", "object"]) {
            ensure!(
                link.until_connected(STAGE_PATIENCE).await,
                "nobody publishes '{topic}' (waited {STAGE_PATIENCE:.0?}); is the graph running?"
            );
        }
        Ok(Self {
            heard,
            _links: links,
        })
    }

    /// Waits for all messages of a scan that has ended.
    ///
    /// # Errors
    /// Not all of its messages arrived within the time limit.
    pub async fn of(&self, scan_id: &str) -> Result<Recorded> {
        let whole = async {
            loop {
                let news = self.heard.news.notified();
                let scan = self.heard.scans().get(scan_id).cloned();
                match scan {
                    Some(scan) if scan.is_whole() => return scan,
                    _ => news.await,
                }
            }
        };
        let whole = tokio::time::timeout(CLOUDS_PATIENCE, whole).await;
        whole.context("the clouds of the scan did not all come, so nothing is saved; scan again")
    }
}

impl Recorded {
    fn is_whole(&self) -> bool {
        let count = self.registered.view_count;
        self.registered.complete
            && self.object.complete
            && (0..count).all(|index| self.views.contains_key(&index))
    }
}

impl Heard {
    fn scans(&self) -> MutexGuard<'_, Scans> {
        self.scans.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn of<'a>(scans: &'a mut Scans, scan_id: &str) -> &'a mut Recorded {
    scans.entry(scan_id.into()).or_default()
}

fn on<T, F: Fn(&mut Scans, T)>(heard: &Arc<Heard>, note: F) -> impl Fn(T) + use<T, F> {
    let heard = Arc::clone(heard);
    move |message| {
        note(&mut heard.scans(), message);
        heard.news.notify_waiters();
    }
}
