//! The goals of an action server, as actionlib's simple server keeps them: one is worked on, at most one more waits.
//!
//! A new goal preempts the one that is worked on, and replaces the one that waits. All that clients see of it is the list
//! of statuses and, once for each goal, its last one with the result.

use std::time::{Duration, Instant};

/// How long the list tells of a goal that has ended, as in actionlib.
const REMEMBERED: Duration = Duration::from_secs(5);

/// State of a goal; the numbers are those of `actionlib_msgs/GoalStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// It waits.
    Pending = 0,
    /// It is worked on.
    Active = 1,
    /// Ended: given up while it was worked on.
    Preempted = 2,
    /// Ended well.
    Succeeded = 3,
    /// Ended: it failed.
    Aborted = 4,
    /// To be given up; the work is not at its end yet.
    Preempting = 6,
    /// Cancelled before it came.
    Recalling = 7,
    /// Ended before it was worked on.
    Recalled = 8,
}

/// How work on a goal ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Well.
    Succeeded,
    /// It failed.
    Aborted,
    /// It was given up, as somebody wished.
    Preempted,
}

/// Which goal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GoalId {
    /// Unique name; in a cancellation, empty: all.
    pub id: String,
    /// When it was asked for, ROS time; 0: not said.
    pub stamp_ns: i64,
}

/// A goal as clients see it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GoalState {
    /// Which goal.
    pub id: GoalId,
    /// Its state.
    pub status: Status,
    /// Why, in words; may be empty.
    pub text: String,
}

/// All goals of a server, each with a request of type `G`.
#[derive(Debug, Default)]
pub struct Goals<G> {
    known: Vec<Known>,
    waiting: Option<(GoalId, G)>,
    /// Goals that are not younger are cancelled when they come.
    last_cancel_ns: i64,
    /// Why no more goals are taken.
    closed: Option<String>,
}

#[derive(Debug)]
struct Known {
    state: GoalState,
    ended: Option<Instant>,
}

impl<G> Goals<G> {
    /// Without goals.
    pub fn new() -> Self {
        Self {
            known: Vec::new(),
            waiting: None,
            last_cancel_ns: 0,
            closed: None,
        }
    }

    /// Takes a goal; gives those that thereby ended without having been worked on. One that comes twice counts once.
    pub fn receive(&mut self, id: GoalId, goal: G, now: Instant) -> Vec<GoalState> {
        if let Some(index) = self.index_of(&id.id) {
            let was_cancelled = self.known[index].state.status == Status::Recalling;
            let end = was_cancelled.then(|| self.recall(index, "cancelled before it came", now));
            return end.into_iter().collect();
        }
        let newest_ns = self.unfinished().map(|state| state.id.stamp_ns).max();
        let index = self.known.len();
        self.known.push(Known {
            state: GoalState {
                id: id.clone(),
                status: Status::Pending,
                text: String::new(),
            },
            ended: None,
        });
        if let Some(reason) = self.closed.clone() {
            return vec![self.recall(index, &reason, now)];
        }
        if id.stamp_ns != 0 && id.stamp_ns <= self.last_cancel_ns {
            return vec![self.recall(index, "older than a cancellation of all goals", now)];
        }
        if newest_ns.is_some_and(|newest_ns| id.stamp_ns < newest_ns) {
            return vec![self.recall(index, "older than another goal", now)];
        }
        let replaced = self.waiting.replace((id, goal));
        let replaced = replaced.and_then(|(id, _)| self.index_of(&id.id));
        let ended = replaced.map(|index| self.recall(index, "replaced by a newer goal", now));
        self.preempt(|_| true, "preempted by a newer goal");
        ended.into_iter().collect()
    }

    /// Cancels the goal named, and all that are not younger than a stamp; neither name nor stamp: all. Gives those that
    /// thereby ended without having been worked on.
    pub fn cancel(&mut self, cancelled: &GoalId, now: Instant) -> Vec<GoalState> {
        let is_all = cancelled.id.is_empty() && cancelled.stamp_ns == 0;
        let concerns = |id: &GoalId| {
            let is_named = !cancelled.id.is_empty() && id.id == cancelled.id;
            let is_old = cancelled.stamp_ns != 0 && id.stamp_ns <= cancelled.stamp_ns;
            is_all || is_named || is_old
        };
        self.last_cancel_ns = self.last_cancel_ns.max(cancelled.stamp_ns);
        self.preempt(concerns, "cancelled");
        if !cancelled.id.is_empty() && self.index_of(&cancelled.id).is_none() {
            // It is still on its way.
            let (id, status, text) = (cancelled.clone(), Status::Recalling, String::new());
            self.known.push(Known {
                state: GoalState { id, status, text },
                ended: Some(now),
            });
        }
        let waiting = self.waiting.take_if(|(id, _)| concerns(id));
        let waiting = waiting.and_then(|(id, _)| self.index_of(&id.id));
        let ended = waiting.map(|index| self.recall(index, "cancelled", now));
        ended.into_iter().collect()
    }

    /// Takes no more goals, for this reason. Gives the one that thereby ended without having been worked on.
    pub fn close(&mut self, reason: &str, now: Instant) -> Vec<GoalState> {
        self.closed = Some(reason.into());
        let waiting = self.waiting.take();
        let waiting = waiting.and_then(|(id, _)| self.index_of(&id.id));
        let ended = waiting.map(|index| self.recall(index, reason, now));
        ended.into_iter().collect()
    }

    /// Begins work on the goal that waits, unless another is still worked on.
    pub fn start(&mut self) -> Option<(GoalId, G)> {
        if self.running().is_some() {
            return None;
        }
        let (id, goal) = self.waiting.take()?;
        let index = self.index_of(&id.id)?;
        self.known[index].state.status = Status::Active;
        Some((id, goal))
    }

    /// The goal that is worked on.
    pub fn running(&self) -> Option<&GoalState> {
        self.unfinished()
            .find(|state| matches!(state.status, Status::Active | Status::Preempting))
    }

    /// Whether the work is to be given up.
    pub fn is_preempting(&self) -> bool {
        self.running()
            .is_some_and(|state| state.status == Status::Preempting)
    }

    /// Ends the work, and says so in words; who gave it up was already said. Gives the goal's last state.
    pub fn finish(&mut self, outcome: Outcome, text: &str, now: Instant) -> Option<GoalState> {
        let index = self
            .running()
            .and_then(|state| self.index_of(&state.id.id))?;
        let status = match outcome {
            Outcome::Succeeded => Status::Succeeded,
            Outcome::Aborted => Status::Aborted,
            Outcome::Preempted => Status::Preempted,
        };
        if outcome != Outcome::Preempted {
            self.known[index].state.text = text.into();
        }
        Some(self.end(index, status, now))
    }

    /// What the status topic says now: all goals but those that ended a while ago.
    pub fn list(&mut self, now: Instant) -> Vec<GoalState> {
        self.known.retain(|known| {
            known
                .ended
                .is_none_or(|ended| now.saturating_duration_since(ended) < REMEMBERED)
        });
        self.known.iter().map(|known| known.state.clone()).collect()
    }

    /// Forgets stamps, which mean nothing after ROS time was set back.
    pub fn forget_stamps(&mut self) {
        self.last_cancel_ns = 0;
        for known in &mut self.known {
            known.state.id.stamp_ns = 0;
        }
    }

    fn index_of(&self, id: &str) -> Option<usize> {
        self.known.iter().position(|known| known.state.id.id == id)
    }

    fn unfinished(&self) -> impl Iterator<Item = &GoalState> {
        self.known
            .iter()
            .filter(|known| known.ended.is_none())
            .map(|known| &known.state)
    }

    fn preempt(&mut self, concerns: impl Fn(&GoalId) -> bool, text: &str) {
        for known in &mut self.known {
            if known.state.status == Status::Active && concerns(&known.state.id) {
                known.state.status = Status::Preempting;
                known.state.text = text.into();
            }
        }
    }

    fn recall(&mut self, index: usize, text: &str, now: Instant) -> GoalState {
        self.known[index].state.text = text.into();
        self.end(index, Status::Recalled, now)
    }

    fn end(&mut self, index: usize, status: Status, now: Instant) -> GoalState {
        let known = &mut self.known[index];
        known.state.status = status;
        known.ended = Some(now);
        known.state.clone()
    }
}

#[cfg(test)]
mod tests;
