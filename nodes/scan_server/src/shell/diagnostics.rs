//! What the other nodes say is wrong, so that a scan that fails can tell its caller.

use msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use node::{Expect, Node, Subscriber};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Diagnostics come each second; what is older is no longer so.
const FRESH: Duration = Duration::from_secs(3);
/// After this, each node has spoken since.
const ROUND: Duration = Duration::from_millis(1200);

/// The stages that views are handed on to.
const LATER_STAGES: [&str; 3] = ["icp_registration", "roi_crop", "classifier"];

/// Listens to /diagnostics. Clones share it.
#[derive(Clone)]
pub struct Diagnostics {
    heard: Arc<Mutex<Heard>>,
    _link: Subscriber,
}

/// By "node: part", what was said and when.
#[derive(Default)]
struct Heard(BTreeMap<String, (i8, String, Instant)>);

impl Diagnostics {
    /// Listens from now on.
    pub fn listen(node: &Node) -> anyhow::Result<Self> {
        let heard = Arc::new(Mutex::new(Heard::default()));
        let link = node.subscribe("/diagnostics", Expect::SPORADIC, {
            let heard = Arc::clone(&heard);
            move |array: DiagnosticArray| {
                heard
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .note(array, Instant::now());
            }
        })?;
        Ok(Self { heard, _link: link })
    }

    /// A clause for an error text: all warnings and errors, once each node has spoken since a moment; empty if there are none.
    pub async fn clause(&self, since: tokio::time::Instant) -> String {
        tokio::time::sleep_until(since + ROUND).await;
        self.heard
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clause(Instant::now())
    }

    /// Those of the later stages that are silent.
    pub fn silent_stages(&self) -> Vec<&'static str> {
        self.heard
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .silent_stages(Instant::now())
    }
}

impl Heard {
    fn note(&mut self, array: DiagnosticArray, now: Instant) {
        for status in array.status {
            self.0
                .insert(status.name, (status.level, status.message, now));
        }
    }

    fn fresh(&self, now: Instant) -> impl Iterator<Item = (&String, i8, &String)> {
        self.0
            .iter()
            .filter(move |(_, (.., when))| now.duration_since(*when) < FRESH)
            .map(|(name, (level, message, _))| (name, *level, message))
    }

    fn clause(&self, now: Instant) -> String {
        let warnings: Vec<_> = self
            .fresh(now)
            .filter(|(_, level, _)| *level != DiagnosticStatus::OK)
            .map(|(name, _, message)| format!("{name}: {message}"))
            .collect();
        if warnings.is_empty() {
            String::new()
        } else {
            format!("; diagnostics: {}", warnings.join("; "))
        }
    }

    fn silent_stages(&self, now: Instant) -> Vec<&'static str> {
        let speaks = |stage: &&str| {
            self.fresh(now)
                .any(|(name, ..)| node_of(name).is_some_and(|node| node.ends_with(stage)))
        };
        LATER_STAGES
            .into_iter()
            .filter(|stage| !speaks(stage))
            .collect()
    }
}

/// The node in the name of a status, "node: part".
fn node_of(name: &str) -> Option<&str> {
    name.split_once(':').map(|(node, _)| node)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(name: &str, level: i8, message: &str) -> DiagnosticArray {
        let status = DiagnosticStatus {
            name: name.into(),
            level,
            message: message.into(),
            ..Default::default()
        };
        DiagnosticArray {
            status: vec![status],
            ..Default::default()
        }
    }

    #[test]
    fn only_fresh_warnings_are_told() {
        let (mut heard, now) = (Heard::default(), Instant::now());
        heard.note(said("roi_crop: links", DiagnosticStatus::OK, ""), now);
        assert_eq!(heard.clause(now), "");
        let images = said(
            "depth_threshold: images",
            DiagnosticStatus::ERROR,
            "encoding 8UC1",
        );
        heard.note(images, now);
        assert_eq!(
            heard.clause(now),
            "; diagnostics: depth_threshold: images: encoding 8UC1"
        );
        assert_eq!(heard.clause(now + 2 * FRESH), "");
    }

    #[test]
    fn silent_stages_are_named() {
        let (mut heard, now) = (Heard::default(), Instant::now());
        heard.note(
            said("lab/icp_registration: links", DiagnosticStatus::OK, ""),
            now,
        );
        heard.note(said("roi_crop: links", DiagnosticStatus::OK, ""), now);
        assert_eq!(heard.silent_stages(now), ["classifier"]);
        assert_eq!(heard.silent_stages(now + FRESH), LATER_STAGES);
    }
}
