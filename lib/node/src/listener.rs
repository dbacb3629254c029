//! Keeps a [`TransformBuffer`] up to date.

use crate::node::Node;
use crate::subscriber::Subscriber;
use crate::subscription::Expect;
use crate::transforms::{TransformBuffer, TransformError};
use msg::Time;
use msg::tf2_msgs::TFMessage;
use msg::transform::to_isometry;
use nalgebra::Isometry3;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::Instant;

/// The transforms that the node has heard of. Clones share them.
#[derive(Clone)]
pub struct Transforms {
    buffer: Arc<Mutex<TransformBuffer>>,
    news: Arc<Notify>,
    _links: Arc<[Subscriber; 2]>,
}

impl Node {
    /// Listens to /tf and /tf_static. Call it once; clone the result.
    ///
    /// # Errors
    /// The topics cannot be subscribed to.
    pub fn transforms(&self) -> anyhow::Result<Transforms> {
        Transforms::listen(self)
    }
}

impl Transforms {
    fn listen(node: &Node) -> anyhow::Result<Self> {
        let buffer = Arc::new(Mutex::new(TransformBuffer::default()));
        let news = Arc::new(Notify::new());
        let reader = |fixed| {
            let (buffer, news) = (Arc::clone(&buffer), Arc::clone(&news));
            move |message: TFMessage| {
                insert_all(&mut lock(&buffer), &message, fixed);
                news.notify_waiters();
            }
        };
        let many = Expect {
            queue: 100,
            ..Expect::STATE
        };
        let moving = node.subscribe("/tf", many, reader(false))?;
        let fixed = node.subscribe("/tf_static", Expect::SPORADIC, reader(true))?;
        node.clock().on_jump({
            let buffer = Arc::clone(&buffer);
            move || lock(&buffer).forget_motion()
        });
        Ok(Self {
            buffer,
            news,
            _links: Arc::new([moving, fixed]),
        })
    }

    /// target_from_source at `stamp`, as far as is known now.
    ///
    /// # Errors
    /// [`TransformError`]: the frames are not connected, or not known at that time.
    pub fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp: Time,
    ) -> Result<Isometry3<f64>, TransformError> {
        lock(&self.buffer).lookup(target, source, stamp.nanos())
    }

    /// target_from_source at `stamp`, waiting up to `patience` for what may still arrive.
    ///
    /// # Errors
    /// [`TransformError`], as for [`Transforms::lookup`], once `patience` is over.
    pub async fn wait(
        &self,
        target: &str,
        source: &str,
        stamp: Time,
        patience: Duration,
    ) -> Result<Isometry3<f64>, TransformError> {
        let deadline = Instant::now() + patience;
        loop {
            let news = self.news.notified();
            let result = self.lookup(target, source, stamp);
            let may_come = !matches!(result, Ok(_) | Err(TransformError::TooOld { .. }));
            if !may_come || tokio::time::timeout_at(deadline, news).await.is_err() {
                return result;
            }
        }
    }
}

pub(crate) fn insert_all(buffer: &mut TransformBuffer, message: &TFMessage, fixed: bool) {
    for entry in &message.transforms {
        match to_isometry(&entry.transform) {
            Some(pose) => buffer.insert(
                &entry.header.frame_id,
                &entry.child_frame_id,
                entry.header.stamp.nanos(),
                pose,
                fixed,
            ),
            None => log::warn!(
                "TF of '{}' has a broken rotation; ignored",
                entry.child_frame_id
            ),
        }
    }
}

fn lock(buffer: &Mutex<TransformBuffer>) -> std::sync::MutexGuard<'_, TransformBuffer> {
    buffer.lock().unwrap_or_else(PoisonError::into_inner)
}
