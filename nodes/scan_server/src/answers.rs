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
    sure_from: Option<f64>,
}

impl Answers {
    /// Listens from now on. A known object with a probability of `sure_from` ends the scan; `None`: no running answer does.
    pub fn new(all: &Sender<Classification>, scan_id: &str, sure_from: Option<f64>) -> Self {
        Self {
            scan_id: scan_id.into(),
            heard: all.subscribe(),
            newest: None,
            sure_from,
        }
    }

    /// Whether a running answer may end the scan.
    pub fn may_end_scan(&self) -> bool {
        self.sure_from.is_some()
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
        let is_sure = |sure_from| answer.probability >= sure_from;
        Ok(answer.error.is_empty() && answer.known && self.sure_from.is_some_and(is_sure))
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
    async fn only_a_known_and_sure_answer_ends_a_scan() {
        let all = Sender::new(16);
        let said = |known, probability| Classification {
            known,
            probability,
            ..answer("a", 1, false)
        };
        for (sure_from, sent, suffices) in [
            (Some(0.9), said(true, 0.9), true),
            (Some(0.9), said(true, 0.89), false),
            (Some(0.9), said(true, f64::NAN), false),
            (Some(0.9), said(false, 1.0), false),
            (None, said(true, 1.0), false),
        ] {
            let mut answers = Answers::new(&all, "a", sure_from);
            assert!(!answers.suffice().unwrap());
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
