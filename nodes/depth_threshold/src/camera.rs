//! Subscribes to the camera's depth images, raw or compressed.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Error;
use depth_threshold::{CompressedError, DepthImage, Unpacked};
use msg::sensor_msgs::{CompressedImage, Image};
use msg::std_msgs::Header;
use node::{Expect, Node, Subscriber};

const TOPIC: &str = "camera/depth/image_rect_raw";
/// Name that image_transport appends to the topic of compressed depth images. Most bags hold these.
const PACKED: &str = "compressedDepth";
/// Watchdog: after this time without an image, the node asks the master whether the other topic is published.
const PATIENCE: Duration = Duration::from_secs(2);

/// A depth image message, raw or compressed.
pub enum Picture {
    Plain(Image),
    Packed(CompressedImage),
}

impl Picture {
    /// Calls `work` with the image, decompressed if necessary.
    ///
    /// # Errors
    /// A compressed image cannot be decompressed.
    pub fn with_image<T>(&self, work: impl FnOnce(&DepthImage) -> T) -> Result<T, CompressedError> {
        match self {
            Self::Plain(image) => Ok(work(&DepthImage {
                width: image.width,
                height: image.height,
                step: image.step,
                encoding: &image.encoding,
                is_bigendian: image.is_bigendian != 0,
                data: &image.data,
            })),
            Self::Packed(packed) => {
                let unpacked = Unpacked::new(&packed.format, &packed.data)?;
                Ok(work(&unpacked.image()))
            }
        }
    }

    pub fn into_header(self) -> Header {
        match self {
            Self::Plain(image) => image.header,
            Self::Packed(packed) => packed.header,
        }
    }
}

type Take = dyn Fn(&str, Picture) + Send + Sync;

/// Subscribes to one topic at a time: the raw one, or the compressed one if only that is published.
pub struct Camera {
    node: Node,
    /// Resolved name of the raw topic: with namespace and remapping.
    topic: String,
    packed_topic: String,
    take: Arc<Take>,
    last: Arc<Mutex<Instant>>,
}

impl Camera {
    /// `take` is called with each image and its topic's name without image_transport's suffix.
    pub fn new(node: &Node, take: impl Fn(&str, Picture) + Send + Sync + 'static) -> Self {
        let topic = node.resolved(TOPIC);
        Self {
            node: node.clone(),
            packed_topic: format!("{topic}/{PACKED}"),
            topic,
            take: Arc::new(take),
            last: Arc::new(Mutex::new(Instant::now())),
        }
    }

    /// Receives images until an error occurs, which is returned.
    pub async fn watch(self) -> Error {
        let mut is_packed = false;
        loop {
            // The subscription lasts as long as this value.
            let _heard = match self.subscribe(is_packed) {
                Ok(heard) => heard,
                Err(error) => return error,
            };
            while !self.is_elsewhere(is_packed).await {}
            is_packed = !is_packed;
            let topic = if is_packed {
                &self.packed_topic
            } else {
                &self.topic
            };
            log::info!("depth images are taken from {topic}, since nobody publishes the other");
        }
    }

    fn subscribe(&self, is_packed: bool) -> anyhow::Result<Subscriber> {
        let (take, topic, last) = (
            Arc::clone(&self.take),
            self.topic.clone(),
            Arc::clone(&self.last),
        );
        let note = move || *last.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        if is_packed {
            self.node.subscribe(
                &self.packed_topic,
                Expect::STATE,
                move |packed: CompressedImage| {
                    note();
                    take(&topic, Picture::Packed(packed));
                },
            )
        } else {
            self.node
                .subscribe(TOPIC, Expect::STATE, move |image: Image| {
                    note();
                    take(&topic, Picture::Plain(image));
                })
        }
    }

    /// Waits, and if no image has arrived meanwhile, asks the master whether only the other topic is published.
    async fn is_elsewhere(&self, is_packed: bool) -> bool {
        tokio::time::sleep(PATIENCE / 2).await;
        let last = *self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() < PATIENCE {
            return false;
        }
        let node = self.node.clone();
        let (here, there) = match is_packed {
            false => (self.topic.clone(), self.packed_topic.clone()),
            true => (self.packed_topic.clone(), self.topic.clone()),
        };
        let asked = tokio::task::spawn_blocking(move || -> anyhow::Result<bool> {
            Ok(node.publishers_of(&here)?.is_empty() && !node.publishers_of(&there)?.is_empty())
        });
        // If the master cannot be reached, stay with the present topic.
        matches!(asked.await, Ok(Ok(true)))
    }
}
