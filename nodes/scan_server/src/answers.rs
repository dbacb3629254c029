//! The classifier's answers to one scan.

use anyhow::ensure;
use msg::deformable_cobot::Classification;
use std::future::pending;
use std::time::Duration;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::broadcast::{Receiver, Sender};

/// What the classifier has said of a scan so far.
pub struct Answers {
    scan_id: String,
    heard: Receiver<Classification>,
    newest: Option<Classification>,
    early_end: Option<EarlyEnd>,
    /// Wrist angles of the views that were handed on, rad.
    angles_rad: Vec<f64>,
}

/// Which running answers end a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarlyEnd {
    /// Least probability of a known object.
    pub probability_min: f64,
    /// How far the wrist must have turned between the answer's views, rad.
    pub turn_min_rad: f64,
}

impl Answers {
    /// Listens from now on; `None`: no running answer ends the scan.
    pub fn new(all: &Sender<Classification>, scan_id: &str, early_end: Option<EarlyEnd>) -> Self {
        Self {
            scan_id: scan_id.into(),
            heard: all.subscribe(),
            newest: None,
            early_end,
            angles_rad: Vec::new(),
        }
    }

    /// Whether a running answer may end the scan.
    pub fn may_end_scan(&self) -> bool {
        self.early_end.is_some()
    }

    /// Takes the wrist angle of a view that is handed on, rad.
    pub fn note_view(&mut self, angle_rad: f64) {
        self.angles_rad.push(angle_rad);
    }

    /// How far the wrist turned between the first so many views, rad.
    fn turned_rad(&self, view_count: u32) -> f64 {
        let seen = self.angles_rad.iter().take(view_count as usize);
        let [least, most] = seen.fold([f64::MAX, f64::MIN], |[least, most], angle_rad| {
            [least.min(*angle_rad), most.max(*angle_rad)]
        });
        most - least
    }

    /// Whether the newest answer ends the scan.
    ///
    /// # Errors
    /// What a later stage says that has failed.
    pub fn suffice(&self) -> anyhow::Result<bool> {
        let Some(answer) = &self.newest else {
            return Ok(false);
        };
        ensure!(
            !answer.complete || answer.error.is_empty(),
            "{}",
            answer.error
        );
        let is_sure = |end: EarlyEnd| {
            answer.probability >= end.probability_min
                && self.turned_rad(answer.view_count) >= end.turn_min_rad
        };
        Ok(answer.error.is_empty() && answer.known && self.early_end.is_some_and(is_sure))
    }

    /// The newest answer, waited for until it is about this many views or ends the scan; `None` if none came in time.
    pub async fn about(&mut self, view_count: u32, patience: Duration) -> Option<&Classification> {
        let wanted = |answer: &Classification| answer.complete || answer.view_count >= view_count;
        let _ = tokio::time::timeout(patience, self.until(wanted)).await;
        self.newest.as_ref()
    }

    /// The answer to the whole scan; `None` if it did not come in time.
    pub async fn last(&mut self, patience: Duration) -> Option<&Classification> {
        let _ = tokio::time::timeout(patience, self.until(|answer| answer.complete)).await;
        self.newest.as_ref().filter(|answer| answer.complete)
    }

    /// The next answer to this scan. Given up before it has come, it loses none.
    pub async fn next(&mut self) -> &Classification {
        loop {
            match self.heard.recv().await {
                Ok(answer) if answer.scan_id == self.scan_id => return self.newest.insert(answer),
                Ok(_) | Err(RecvError::Lagged(_)) => {}
                // The sender lives as long as the scanner; the deadline ends the wait.
                Err(RecvError::Closed) => pending().await,
            }
        }
    }

    async fn until(&mut self, wanted: impl Fn(&Classification) -> bool) {
        while !self.newest.as_ref().is_some_and(&wanted) {
            self.next().await;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn answer(scan_id: &str, view_count: u32, complete: bool) -> Classification {
        Classification {
            scan_id: scan_id.into(),
            view_count,
            complete,
            ..Default::default()
        }
    }

    #[tokio::test]
    async fn the_newest_answer_to_this_scan_counts() {
        let all = Sender::new(16);
        let mut answers = Answers::new(&all, "b", None);
        assert!(answers.about(1, Duration::ZERO).await.is_none());
        for sent in [answer("a", 3, true), answer("b", 1, false)] {
            all.send(sent).unwrap();
        }
        assert_eq!(
            answers.about(2, Duration::ZERO).await.unwrap().view_count,
            1
        );
        assert!(answers.last(Duration::ZERO).await.is_none());
        all.send(answer("b", 2, false)).unwrap();
        all.send(answer("b", 2, true)).unwrap();
        let last = answers.last(Duration::from_secs(5)).await.unwrap();
        assert_eq!((last.view_count, last.complete), (2, true));
    }

    #[tokio::test]
    async fn a_wait_that_is_given_up_loses_no_answer() {
        let all = Sender::new(16);
        let mut answers = Answers::new(&all, "a", None);
        all.send(answer("a", 1, true)).unwrap();
        assert_eq!(answers.next().await.view_count, 1);
        let given_up = tokio::time::timeout(Duration::ZERO, answers.next()).await;
        assert!(given_up.is_err());
        assert!(answers.last(Duration::ZERO).await.is_some());
    }

    #[tokio::test]
    async fn only_a_known_and_sure_answer_to_a_turn_ends_a_scan() {
        let all = Sender::new(16);
        let said = |known, probability, view_count| Classification {
            known,
            probability,
            ..answer("a", view_count, false)
        };
        let end = Some(EarlyEnd {
            probability_min: 0.9,
            turn_min_rad: 0.18,
        });
        for (early_end, sent, suffices) in [
            (end, said(true, 0.9, 3), true),
            (end, said(true, 0.9, 2), false),
            (end, said(true, 0.9, 0), false),
            (end, said(true, 0.89, 3), false),
            (end, said(true, f64::NAN, 3), false),
            (end, said(false, 1.0, 3), false),
            (None, said(true, 1.0, 3), false),
        ] {
            let mut answers = Answers::new(&all, "a", early_end);
            assert!(!answers.suffice().unwrap());
            for angle_rad in [1.25, 1.2, 1.05] {
                answers.note_view(angle_rad);
            }
            all.send(sent).unwrap();
            answers.next().await;
            assert_eq!(answers.suffice().unwrap(), suffices, "{:?}", answers.newest);
        }
    }

    #[tokio::test]
    async fn a_scan_that_has_failed_is_not_waited_for() {
        let all = Sender::new(16);
        let mut answers = Answers::new(&all, "a", None);
        all.send(answer("a", 0, true)).unwrap();
        assert!(
            answers
                .about(2, Duration::from_secs(600))
                .await
                .unwrap()
                .complete
        );
    }
}
