//! The difference between the clocks of joint states and images: learned from each sweep, and kept for the next.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::ensure;
use msg::Time;
use msg::deformable_cobot::RegisteredCloud;
use node::{Expect, Level, Node, Subscriber, Tuned};
use view_capture::{ClockDifference, Parameters};

/// What is known of it. Clones share it.
#[derive(Clone)]
pub struct TimeOffset {
    node: Node,
    parameters: Tuned<Parameters>,
    known: Arc<Mutex<Known>>,
}

#[derive(Default)]
struct Known {
    difference: ClockDifference,
    /// The last scan that told: its last message comes more than once.
    scan_id: String,
}

impl TimeOffset {
    /// Learns from now on, as long as the subscriber is kept.
    pub fn learn(
        node: &Node,
        parameters: &Tuned<Parameters>,
    ) -> anyhow::Result<(Self, Subscriber)> {
        let offset = Self {
            node: node.clone(),
            parameters: parameters.clone(),
            known: Arc::default(),
        };
        let link = node.subscribe("registered", Expect::EVENTS, {
            let offset = offset.clone();
            move |cloud: RegisteredCloud| {
                if cloud.complete && cloud.error.is_empty() && cloud.doubt.is_empty() {
                    offset.note(&cloud);
                }
            }
        })?;
        Ok((offset, link))
    }

    /// The moment, by the joints' clock, at which an image was taken.
    pub fn moment_of(&self, stamp: Time) -> Time {
        let offset_ns = (self.lock().difference.offset_s * 1e9) as i64;
        Time::from_nanos(stamp.nanos().saturating_add(offset_ns).max(0))
    }

    /// Are the clocks near enough to each other for a sweep?
    pub fn check(&self) -> anyhow::Result<()> {
        let (max_s, known) = (
            self.parameters.now().time_offset_max_s,
            self.lock().difference,
        );
        ensure!(
            known.offset_s.abs() <= max_s,
            "images are taken {:.0} ± {:.0} ms later than their stamps say by the joints' clock, more than {:.0} ms \
             (time_offset_max_s); bring the clocks into step (chronyc makestep), or ask for views at rest",
            1e3 * known.offset_s,
            1e3 * known.sigma_s,
            1e3 * max_s
        );
        Ok(())
    }

    fn note(&self, cloud: &RegisteredCloud) {
        let mut known = self.lock();
        if known.scan_id == cloud.scan_id || cloud.time_offset_sigma <= 0.0 {
            return;
        }
        known.scan_id.clone_from(&cloud.scan_id);
        known
            .difference
            .learn(cloud.time_offset, cloud.time_offset_sigma);
        let difference = known.difference;
        drop(known);
        let text = format!(
            "images are taken {:.1} ± {:.1} ms later than their stamps say by the joints' clock",
            1e3 * difference.offset_s,
            1e3 * difference.sigma_s
        );
        log::info!("{text}");
        let is_large = difference.offset_s.abs() > self.parameters.now().time_offset_max_s;
        let level = if is_large { Level::Warn } else { Level::Ok };
        self.node.health().set("time offset", level, text);
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
