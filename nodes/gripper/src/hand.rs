//! The interface of a gripper: tasks, outcomes, and the trait of its protocols.

use std::time::{Duration, Instant};

use baxter::{Aged, Silence};

use crate::error::GraspError;

/// Target of the fingers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// Fully open.
    Open,
    /// Closed, or onto the object between them.
    Close,
    /// This distance apart, m, or onto the object between them.
    Width(f64),
}

/// One grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// Target of the fingers.
    pub goal: Goal,
    /// Share of the largest force at which the fingers stop, above 0 and up to 1; `None`: as configured.
    pub force: Option<f64>,
}

/// Outcome of a successful grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The fingers hold something.
    Gripped,
    /// They closed to the end of their travel and met nothing.
    Missed,
    /// They reached their target and met nothing.
    Reached,
}

/// The end of a grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grasped {
    /// What the fingers met.
    pub outcome: Outcome,
    /// Their distance now, metres.
    pub width_m: f64,
}

/// What the caller has to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Step<C> {
    /// Send this command.
    Send(C),
    /// Nothing: the hand is moving.
    Wait,
    /// Nothing any more: the grasp has ended.
    Done(Grasped),
}

/// The last message of a gripper on `topic`, if it is fresh.
///
/// # Errors
/// There is none, or it is older than `age_max`.
pub(crate) fn fresh_state<'a, T>(
    last: Option<&'a Aged<T>>,
    age_max: Duration,
    topic: &str,
    now: Instant,
) -> Result<&'a T, GraspError> {
    let topic = topic.to_owned();
    baxter::fresh(last, age_max, now).map_err(|silence| match silence {
        Silence::Never => GraspError::Absent { topic },
        Silence::Stale { age_s, max_s } => GraspError::Silent {
            topic,
            age_s,
            max_s,
        },
    })
}

/// A gripper's protocol as a state machine. It does one task at a time: [`Hand::begin`], then [`Hand::step`] at 100 Hz until
/// that returns [`Step::Done`] or an error.
pub trait Hand {
    /// What the gripper publishes.
    type State;
    /// What it is sent.
    type Command;

    /// Takes a message of the gripper.
    fn hear(&mut self, state: Self::State, now: Instant);

    /// Checks that the gripper is connected and ready for a task.
    ///
    /// # Errors
    /// Why it is not.
    fn check(&self, now: Instant) -> Result<(), GraspError>;

    /// Starts a task, in place of any other.
    ///
    /// # Errors
    /// The task cannot be done; no command was issued.
    fn begin(&mut self, task: Task, now: Instant) -> Result<(), GraspError>;

    /// Advances the task.
    ///
    /// # Errors
    /// The task has failed; call [`Hand::halt`] next.
    fn step(&mut self, now: Instant) -> Result<Step<Self::Command>, GraspError>;

    /// Abandons the task. Returns the command that stops the fingers where they are, if one is needed.
    fn halt(&mut self) -> Option<Self::Command>;

    /// Last measured distance between the fingers, m.
    fn width_m(&self) -> Option<f64>;
}

impl Task {
    /// Parses a request.
    ///
    /// # Errors
    /// An unknown command, a width that is not a positive number, or a force outside of 0 to 1.
    pub fn new(command: &str, width_m: f64, force: f64) -> Result<Self, GraspError> {
        let goal = match command {
            "open" => Goal::Open,
            "close" => Goal::Close,
            // Also refuses what is not a number.
            "width" if width_m >= 0.0 => Goal::Width(width_m),
            "width" => return Err(GraspError::Width { width_m }),
            _ => return Err(GraspError::Command(command.to_owned())),
        };
        if !(0.0..=1.0).contains(&force) {
            return Err(GraspError::Force { force });
        }
        let force = Some(force).filter(|force| *force > 0.0);
        Ok(Self { goal, force })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_understood_or_refused_by_name() {
        let close = Task {
            goal: Goal::Close,
            force: None,
        };
        assert_eq!(Task::new("close", f64::NAN, 0.0), Ok(close));
        let gentle = Task {
            goal: Goal::Width(0.06),
            force: Some(0.2),
        };
        assert_eq!(Task::new("width", 0.06, 0.2), Ok(gentle));
        let refusal = |command, width_m, force| {
            Task::new(command, width_m, force).map_err(|error| error.to_string())
        };
        for (request, word) in [
            (refusal("shut", 0.0, 0.0), "shut"),
            (refusal("width", f64::NAN, 0.0), "NaN"),
            (refusal("width", -0.1, 0.0), "-0.1"),
            (refusal("open", 0.0, 1.5), "1.5"),
            (refusal("open", 0.0, f64::NAN), "NaN"),
        ] {
            assert!(
                request.as_ref().is_err_and(|text| text.contains(word)),
                "{request:?}"
            );
        }
    }
}
