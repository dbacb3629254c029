//! What is asked of a hand, and what comes of it.

use std::time::Instant;

use crate::error::GraspError;

/// Where the fingers are to go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goal {
    /// As far apart as they can be.
    Open,
    /// Together, or onto what is between them.
    Close,
    /// So many metres apart, or onto what is between them.
    Width(f64),
}

/// One grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// Where to.
    pub goal: Goal,
    /// Share of the largest force at which the fingers stop, above 0 and up to 1; `None`: as configured.
    pub force: Option<f64>,
}

/// How a grasp ended well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The fingers hold something.
    Gripped,
    /// They closed to the end of their travel and met nothing.
    Missed,
    /// They are where they were to go, and met nothing.
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

/// What to do now.
#[derive(Debug, Clone, PartialEq)]
pub enum Step<C> {
    /// Send this.
    Send(C),
    /// Nothing: the hand is at work.
    Wait,
    /// Nothing more: the grasp has ended.
    Done(Grasped),
}

/// A gripper's protocol. It does one task at a time: [`Hand::begin`], then [`Hand::step`] a hundred times a second until it
/// returns the end or an error.
pub trait Hand {
    /// What the gripper publishes.
    type State;
    /// What it is sent.
    type Command;

    /// Takes a message of the gripper.
    fn hear(&mut self, state: Self::State, now: Instant);

    /// Is the gripper there, and fit for a task?
    ///
    /// # Errors
    /// Why not.
    fn check(&self, now: Instant) -> Result<(), GraspError>;

    /// Starts a task, in place of any other.
    ///
    /// # Errors
    /// It cannot be done; nothing is to be sent.
    fn begin(&mut self, task: Task, now: Instant) -> Result<(), GraspError>;

    /// What to do now for the task.
    ///
    /// # Errors
    /// The task has failed; [`Hand::halt`] next.
    fn step(&mut self, now: Instant) -> Result<Step<Self::Command>, GraspError>;

    /// Gives the task up: the command that stops the fingers where they are, where one is needed.
    fn halt(&mut self) -> Option<Self::Command>;

    /// Distance between the fingers, metres, as last heard.
    fn width_m(&self) -> Option<f64>;
}

impl Task {
    /// From the words and numbers of a request.
    ///
    /// # Errors
    /// A command that there is not; a width that is no number above 0; a force outside 0 to 1.
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
