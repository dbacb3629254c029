//! What a client of an action knows of its goal, and what it has to send next.
//!
//! actionlib takes any subscriber of the goal topic for the server, and any message for arrived: a goal, a cancellation or
//! a result that is lost on the way is waited for without end. Here a goal counts as sent once the server's status names
//! it, and as ended once the status says so; until then it is sent again under the same id, which the server knows to be
//! the same goal. It answers one that has ended with its result, again. Everything has a deadline.

use msg::actionlib_msgs::{GoalStatus, GoalStatusArray};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Pause before something is sent again; statuses come five times a second.
const RESEND: Duration = Duration::from_millis(500);
/// How long the server may take to name the goal, and to send the result of one that has ended.
const ANSWER_MAX: Duration = Duration::from_secs(10);
/// A server whose status is silent for so long is gone.
const SILENCE_MAX: Duration = Duration::from_secs(5);
/// How long a cancelled goal may take to end: the arm comes to rest first.
const CANCEL_MAX: Duration = Duration::from_secs(10);

/// What is to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Send {
    /// The goal, under the same id as before.
    Goal,
    /// Its cancellation.
    Cancel,
}

/// A goal without result.
#[derive(Debug, Error, PartialEq)]
pub enum GoalError {
    /// The server's status is silent.
    #[error(
        "scan_server has been silent for {SILENCE_MAX:.0?}; its message is on the console that it runs on"
    )]
    Silent,
    /// It never named the goal.
    #[error("scan_server did not take the goal within {ANSWER_MAX:.0?}")]
    NotTaken,
    /// It named the goal, and does so no more.
    #[error("scan_server was started again meanwhile, so the scan has ended; scan again")]
    Forgotten,
    /// The goal has ended, and its result does not come.
    #[error("the scan has ended, but its result did not come within {ANSWER_MAX:.0?}")]
    NoResult,
    /// Cancelled before it began.
    #[error("the scan was stopped on request: cancelled before it began")]
    Recalled,
    /// A cancelled goal does not end.
    #[error("scan_server did not end the scan within {CANCEL_MAX:.0?}; the arm may still move")]
    NotEnded,
}

/// One goal, until its result has come.
#[derive(Debug)]
pub struct Goal {
    id: String,
    begun: Instant,
    sent: Option<Instant>,
    cancelled: Option<Instant>,
    cancel_sent: Option<Instant>,
    /// When the server's status last came.
    heard: Instant,
    /// What it said of the goal; `None` before it named it.
    status: Option<u8>,
    /// Since when the status says that the goal has ended.
    ended: Option<Instant>,
    is_forgotten: bool,
}

impl Goal {
    /// To be sent.
    pub fn new(id: &str, now: Instant) -> Self {
        Self {
            id: id.into(),
            begun: now,
            sent: None,
            cancelled: None,
            cancel_sent: None,
            heard: now,
            status: None,
            ended: None,
            is_forgotten: false,
        }
    }

    /// Asks for its end; the first time counts.
    pub fn cancel(&mut self, now: Instant) {
        self.cancelled.get_or_insert(now);
    }

    /// Whether it is to end.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.is_some()
    }

    /// Takes what the server says of its goals.
    pub fn on_status(&mut self, statuses: &GoalStatusArray, now: Instant) {
        self.heard = now;
        let named = statuses
            .status_list
            .iter()
            .find(|status| status.goal_id.id == self.id);
        self.is_forgotten = self.status.is_some() && named.is_none();
        if let Some(named) = named {
            self.status = Some(named.status);
            if has_ended(named.status) {
                self.ended.get_or_insert(now);
            }
        }
    }

    /// What is to be sent now, if anything. It counts as sent then.
    ///
    /// # Errors
    /// There will be no result.
    pub fn due(&mut self, now: Instant) -> Result<Option<Send>, GoalError> {
        let over = |since: Instant, max: Duration| now.saturating_duration_since(since) >= max;
        if over(self.heard, SILENCE_MAX) {
            return Err(GoalError::Silent);
        }
        if self.is_forgotten {
            return Err(GoalError::Forgotten);
        }
        if let Some(ended) = self.ended {
            return match over(ended, ANSWER_MAX) {
                true => Err(GoalError::NoResult),
                false => Ok(self.goal_again(now)),
            };
        }
        if let Some(cancelled) = self.cancelled {
            if self.status == Some(GoalStatus::RECALLING) || self.sent.is_none() {
                return Err(GoalError::Recalled);
            }
            if over(cancelled, CANCEL_MAX) {
                return Err(GoalError::NotEnded);
            }
            return Ok(self.cancel_again(now));
        }
        match self.status {
            Some(_) => Ok(None),
            None if over(self.begun, ANSWER_MAX) => Err(GoalError::NotTaken),
            None => Ok(self.goal_again(now)),
        }
    }

    fn goal_again(&mut self, now: Instant) -> Option<Send> {
        is_due(&mut self.sent, now).then_some(Send::Goal)
    }

    fn cancel_again(&mut self, now: Instant) -> Option<Send> {
        let is_taken = self.status == Some(GoalStatus::PREEMPTING);
        (!is_taken && is_due(&mut self.cancel_sent, now)).then_some(Send::Cancel)
    }
}

fn is_due(sent: &mut Option<Instant>, now: Instant) -> bool {
    let is_due = sent.is_none_or(|sent| now.saturating_duration_since(sent) >= RESEND);
    if is_due {
        *sent = Some(now);
    }
    is_due
}

fn has_ended(status: u8) -> bool {
    matches!(
        status,
        GoalStatus::PREEMPTED
            | GoalStatus::SUCCEEDED
            | GoalStatus::ABORTED
            | GoalStatus::REJECTED
            | GoalStatus::RECALLED
            | GoalStatus::LOST
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: Duration = Duration::from_millis(100);

    fn statuses(named: &[(&str, u8)]) -> GoalStatusArray {
        let mut array = GoalStatusArray::default();
        for (id, status) in named {
            let mut entry = GoalStatus {
                status: *status,
                ..Default::default()
            };
            entry.goal_id.id = (*id).into();
            array.status_list.push(entry);
        }
        array
    }

    /// A goal and its server, which says each 0.1 s what `said` gives for the seconds since the start; all that the goal
    /// sends, with the time in s, and its end.
    fn follow(
        cancelled_s: Option<f64>,
        said: impl Fn(f64) -> Option<GoalStatusArray>,
    ) -> (Vec<(f64, Send)>, Option<GoalError>) {
        let begun = Instant::now();
        let mut goal = Goal::new("mine", begun);
        let mut sent = Vec::new();
        for tick in 0..600_u32 {
            let (now, now_s) = (begun + tick * TICK, f64::from(tick) / 10.0);
            if cancelled_s.is_some_and(|cancelled_s| now_s >= cancelled_s) {
                goal.cancel(now);
            }
            if let Some(statuses) = said(now_s) {
                goal.on_status(&statuses, now);
            }
            match goal.due(now) {
                Ok(due) => sent.extend(due.map(|send| (now_s, send))),
                Err(error) => return (sent, Some(error)),
            }
        }
        (sent, None)
    }

    #[test]
    fn a_goal_is_sent_again_until_the_server_names_it() {
        let (sent, end) = follow(None, |now_s| {
            Some(match now_s {
                0.0..1.2 => statuses(&[("another", GoalStatus::ACTIVE)]),
                _ => statuses(&[("mine", GoalStatus::ACTIVE)]),
            })
        });
        assert_eq!(sent, [0.0, 0.5, 1.0].map(|now_s| (now_s, Send::Goal)));
        assert_eq!(end, None);
        let (_, end) = follow(None, |_| Some(statuses(&[])));
        assert_eq!(end, Some(GoalError::NotTaken));
    }

    #[test]
    fn a_result_that_was_lost_is_asked_for_by_the_same_goal() {
        let (sent, end) = follow(None, |now_s| {
            Some(match now_s {
                ..0.1 => statuses(&[]),
                0.1..3.0 => statuses(&[("mine", GoalStatus::ACTIVE)]),
                _ => statuses(&[("mine", GoalStatus::SUCCEEDED)]),
            })
        });
        assert_eq!(sent[..3], [0.0, 3.0, 3.5].map(|now_s| (now_s, Send::Goal)));
        assert_eq!(end, Some(GoalError::NoResult));
    }

    #[test]
    fn a_cancellation_is_sent_again_until_the_server_follows_it() {
        let (sent, end) = follow(Some(2.0), |now_s| {
            Some(match now_s {
                ..0.1 => statuses(&[]),
                0.1..3.2 => statuses(&[("mine", GoalStatus::ACTIVE)]),
                _ => statuses(&[("mine", GoalStatus::PREEMPTING)]),
            })
        });
        let cancels = [2.0, 2.5, 3.0].map(|now_s| (now_s, Send::Cancel));
        assert_eq!(sent[1..], cancels);
        assert_eq!(end, Some(GoalError::NotEnded));
        let (_, end) = follow(Some(1.0), |_| {
            Some(statuses(&[("mine", GoalStatus::RECALLING)]))
        });
        assert_eq!(end, Some(GoalError::Recalled));
    }

    #[test]
    fn a_server_that_is_silent_or_forgets_is_named() {
        let (_, end) = follow(None, |now_s| {
            (now_s < 1.0).then(|| statuses(&[("mine", GoalStatus::ACTIVE)]))
        });
        assert_eq!(end, Some(GoalError::Silent));
        let (_, end) = follow(None, |now_s| {
            Some(match now_s {
                0.0..1.0 => statuses(&[("mine", GoalStatus::ACTIVE)]),
                _ => statuses(&[]),
            })
        });
        assert_eq!(end, Some(GoalError::Forgotten));
    }
}
