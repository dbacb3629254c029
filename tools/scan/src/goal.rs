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
mod tests;
