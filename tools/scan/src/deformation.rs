//! What the node `deformation` says of a scan, where it runs.

use anyhow::Result;
use msg::deformable_cobot::{Deformation, Dent};
use node::{Expect, Node, Subscriber};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;

/// The field of its cloud.
pub const DEVIATION: &str = "deviation";
/// How long the node may take to be found: it need not run.
const NODE_PATIENCE: Duration = Duration::from_secs(1);
/// How long it may take after the label: a node that has just started prepares the reference first.
const ANSWER_PATIENCE: Duration = Duration::from_secs(10);

#[derive(Default)]
struct Heard {
    complete: Mutex<BTreeMap<String, Deformation>>,
    news: Notify,
}

/// Keeps the answers to whole scans.
pub struct Deformations {
    heard: Arc<Heard>,
    link: Subscriber,
}

impl Deformations {
    /// Listens from now on.
    ///
    /// # Errors
    /// The topic cannot be subscribed to.
    pub fn listen(node: &Node) -> Result<Self> {
        let heard = Arc::new(Heard::default());
        let link = node.subscribe("deformation", Expect::EVENTS, {
            let heard = Arc::clone(&heard);
            move |answer: Deformation| heard.note(answer)
        })?;
        Ok(Self { heard, link })
    }

    /// That of a scan which has ended; `None` where nobody measures deformations, or not in time.
    pub async fn of(&self, scan_id: &str) -> Option<Deformation> {
        if !self.link.until_connected(NODE_PATIENCE).await {
            return None;
        }
        let answer = async {
            loop {
                let news = self.heard.news.notified();
                match self.heard.of(scan_id) {
                    Some(answer) => return answer,
                    None => news.await,
                }
            }
        };
        tokio::time::timeout(ANSWER_PATIENCE, answer).await.ok()
    }
}

impl Heard {
    fn note(&self, answer: Deformation) {
        if answer.complete {
            let mut complete = self.complete.lock().unwrap_or_else(PoisonError::into_inner);
            complete.insert(answer.scan_id.clone(), answer);
            self.news.notify_waiters();
        }
    }

    fn of(&self, scan_id: &str) -> Option<Deformation> {
        let complete = self.complete.lock().unwrap_or_else(PoisonError::into_inner);
        complete.get(scan_id).cloned()
    }
}

/// All of it that a program may want, by the message's names.
pub fn to_json(answer: &Deformation) -> Value {
    json!({
        "reason": answer.reason,
        "reference": answer.reference,
        "fits": answer.fits,
        "dents": answer.dents.iter().map(dent).collect::<Vec<_>>(),
        "largest_depth": answer.largest_depth,
        "significance": answer.significance,
        "seen_share": answer.seen_share,
        "undented_rms": answer.undented_rms,
        "unseen_dents": answer.unseen_dents.iter().map(dent).collect::<Vec<_>>(),
        "unseen_reason": answer.unseen_reason,
        "turn_is_open": answer.turn_is_open,
        "width_scale": answer.width_scale,
        "height_scale": answer.height_scale,
        "summary": answer.summary,
    })
}

fn dent(dent: &Dent) -> Value {
    let [centre, centre_in_object] =
        [&dent.centre, &dent.centre_in_object].map(|place| [place.x, place.y, place.z]);
    let [direction, direction_in_object] =
        [&dent.direction, &dent.direction_in_object].map(|way| [way.x, way.y, way.z]);
    json!({
        "centre": centre,
        "direction": direction,
        "centre_in_object": centre_in_object,
        "direction_in_object": direction_in_object,
        "depth": dent.depth,
        "depth_sigma": dent.depth_sigma,
        "width": dent.width,
        "height": dent.height,
        "area": dent.area,
        "significance": dent.significance,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dent_is_told_by_the_names_of_its_message() {
        let mut answer = Deformation {
            summary: "dented: 7 mm at 61 mm height".into(),
            ..Default::default()
        };
        answer.dents.push(Dent {
            depth: 0.007,
            ..Default::default()
        });
        answer.dents[0].centre_in_object.z = 0.061;
        let json = to_json(&answer);
        assert_eq!(json["dents"][0]["depth"], 0.007);
        assert_eq!(json["dents"][0]["centre_in_object"][2], 0.061);
        assert_eq!(json["summary"], "dented: 7 mm at 61 mm height");
    }
}
