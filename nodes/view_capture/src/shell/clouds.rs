//! The clouds on `points`, heard only while somebody wants them: each is an image that depth_threshold converts.

use super::computers::OtherComputers;
use msg::Time;
use msg::sensor_msgs::PointCloud2;
use node::{Expect, Node, Subscriber};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;

/// How long the subscription outlives its last use: the next view of a scan is asked for at once.
const LINGER: Duration = Duration::from_secs(2);

/// A cloud, and when it came.
#[derive(Debug, PartialEq)]
pub struct Shot {
    /// Its stamp is that of the image.
    pub cloud: PointCloud2,
    /// ROS time.
    pub arrived: Time,
}

/// The newest cloud, for those who listen. Clones share it.
#[derive(Clone)]
pub struct Clouds {
    newest: watch::Sender<Option<Arc<Shot>>>,
    listeners: watch::Sender<usize>,
}

/// Keeps the subscription to `points`, until dropped.
pub struct Listening {
    listeners: watch::Sender<usize>,
    /// The newest cloud, which may be of long ago.
    pub shots: watch::Receiver<Option<Arc<Shot>>>,
}

impl Clouds {
    /// Nobody listens yet.
    pub fn new() -> Self {
        Self {
            newest: watch::Sender::new(None),
            listeners: watch::Sender::new(0),
        }
    }

    /// Wants clouds from now on; the first comes some 0.1 s later.
    pub fn listen(&self) -> Listening {
        self.listeners.send_modify(|count| *count += 1);
        Listening {
            listeners: self.listeners.clone(),
            shots: self.newest.subscribe(),
        }
    }

    /// Subscribes while somebody listens, for ever.
    ///
    /// # Errors
    /// `points` is no topic here.
    pub async fn serve(
        &self,
        node: &Node,
        computers: &OtherComputers,
    ) -> anyhow::Result<Infallible> {
        let mut listeners = self.listeners.subscribe();
        loop {
            // The sender lives as long as this does.
            let _ = listeners.wait_for(|count| *count > 0).await;
            let (newest, node, computers) = (self.newest.clone(), node.clone(), computers.clone());
            // Both ask the master, who may take his time.
            let link =
                tokio::task::spawn_blocking(move || subscribe(newest, &node, computers)).await??;
            loop {
                let _ = listeners.wait_for(|count| *count == 0).await;
                let again = listeners.wait_for(|count| *count > 0);
                if tokio::time::timeout(LINGER, again).await.is_err() {
                    break;
                }
            }
            tokio::task::spawn_blocking(move || drop(link)).await?;
        }
    }
}

fn subscribe(
    newest: watch::Sender<Option<Arc<Shot>>>,
    node: &Node,
    computers: OtherComputers,
) -> anyhow::Result<Subscriber> {
    let clock = node.clock();
    node.subscribe("points", Expect::STATE, move |cloud: PointCloud2| {
        computers.note_cloud(cloud.header.stamp);
        let arrived = clock.now();
        newest.send_replace(Some(Arc::new(Shot { cloud, arrived })));
    })
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.listeners.send_modify(|count| *count -= 1);
    }
}
