//! Baxter's electric gripper: commands with JSON arguments, acknowledged in its state.

mod command;
mod state;

use std::time::{Duration, Instant};

use baxter::{Aged, Gap};

use crate::error::GraspError;
use crate::hand::{Goal, Grasped, Hand, Outcome, Step, Task, fresh_state};
use crate::parameters::{ElectricParameters, Parameters};

pub use command::ElectricCommand;
use command::{Configuration, Sender, Verb};
pub use state::{ElectricState, Flag};

/// Hardware ids of grippers that take no positions (from the maker's emulator and SDK).
const SUCTION_ID: u32 = 65_537;
const PASSIVE_ID: u32 = 131_073;

/// The fingers count as still if their position changes by less than this, percent.
const STILL_PERCENT: f64 = 0.5;

/// The client of an electric gripper.
#[derive(Debug, Clone)]
pub struct Electric {
    parameters: ElectricParameters,
    topic: String,
    state_age_max: Duration,
    settle: Duration,
    motion_patience_s: f64,
    sender: Sender,
    state: Option<Aged<ElectricState>>,
    work: Option<Work>,
}

/// A running task.
#[derive(Debug, Clone)]
struct Work {
    task: Task,
    verb: Verb,
    command: ElectricCommand,
    sent: Instant,
    acknowledged: Option<Instant>,
    /// Position of the fingers when the motion was commanded, percent.
    begin: f64,
    /// Position of the fingers, percent, and since when they have been still there.
    rest: (f64, Instant),
}

impl Electric {
    /// `node` names the sender in commands.
    pub fn new(parameters: &Parameters, node: &str) -> Self {
        Self {
            parameters: parameters.electric.clone(),
            topic: format!("{}/state", parameters.electric_base()),
            state_age_max: Duration::from_secs_f64(parameters.state_age_max_s),
            settle: Duration::from_secs_f64(parameters.settle_s),
            motion_patience_s: parameters.motion_patience_s,
            sender: Sender::new(node),
            state: None,
            work: None,
        }
    }

    fn fresh_state(&self, now: Instant) -> Result<&ElectricState, GraspError> {
        let state = fresh_state(self.state.as_ref(), self.state_age_max, &self.topic, now)?;
        match state.id {
            SUCTION_ID => Err(GraspError::OtherKind("a suction cup")),
            PASSIVE_ID => Err(GraspError::OtherKind("a passive one")),
            _ if state.enabled == Flag::False => Err(GraspError::NotEnabled),
            _ => Ok(state),
        }
    }

    fn gap(&self) -> Gap {
        self.parameters.gap
    }

    /// Position at which the task ends if the fingers meet nothing, percent open.
    fn target(&self, goal: Goal) -> Result<f64, GraspError> {
        match goal {
            Goal::Open => Ok(100.0),
            Goal::Close => Ok(0.0),
            Goal::Width(width_m) => {
                let share = self.gap().share(width_m);
                if (0.0..=1.0).contains(&share) {
                    return Ok(100.0 * share);
                }
                let (min_m, max_m) = (self.gap().closed_m, self.gap().open_m);
                Err(GraspError::WidthOutside {
                    width_m,
                    min_m,
                    max_m,
                })
            }
        }
    }

    /// The next verb towards the task: reset and calibration are inserted only if necessary.
    fn next_verb(&self, state: &ElectricState, task: Task) -> Result<Verb, GraspError> {
        let force = |configured: f64| 100.0 * task.force.unwrap_or(configured);
        let parameters = &self.parameters;
        if state.error == Flag::True {
            Ok(Verb::Reset)
        } else if state.calibrated == Flag::True {
            Ok(Verb::Configure(Configuration {
                velocity: 100.0 * parameters.velocity,
                moving_force: force(parameters.moving_force),
                holding_force: force(parameters.holding_force),
                dead_zone: 100.0 * parameters.dead_zone,
            }))
        } else if parameters.calibrate {
            Ok(Verb::Calibrate)
        } else {
            Err(GraspError::NotCalibrated)
        }
    }

    fn order(&mut self, verb: Verb, task: Task, state: &ElectricState, now: Instant) {
        let command = self.sender.command(state.id, verb);
        let begin = state.position;
        self.work = Some(Work {
            task,
            verb,
            command,
            sent: now,
            acknowledged: None,
            begin,
            rest: (begin, now),
        });
    }

    fn patience_s(&self, verb: Verb) -> f64 {
        match verb {
            Verb::Calibrate => self.parameters.calibration_patience_s,
            Verb::Go(_) => self.motion_patience_s,
            _ => self.parameters.acknowledge_patience_s,
        }
    }

    /// Repeats the command until it is acknowledged.
    fn await_acknowledgement(
        &self,
        work: &mut Work,
        state: &ElectricState,
        now: Instant,
    ) -> Result<bool, GraspError> {
        if work.acknowledged.is_none() && work.command.is_echoed_by(state) {
            work.acknowledged = Some(now);
            work.rest = (state.position, now);
        }
        let patience_s = self.parameters.acknowledge_patience_s;
        let waited = now.saturating_duration_since(work.sent);
        if work.acknowledged.is_none() && waited.as_secs_f64() > patience_s {
            let command = work.verb.name();
            return Err(GraspError::NotAcknowledged {
                command,
                patience_s,
            });
        }
        Ok(work.acknowledged.is_some())
    }

    /// Whether an acknowledged command has ended, and if so, how a motion ended.
    fn ended(
        &self,
        work: &mut Work,
        state: &ElectricState,
        now: Instant,
    ) -> Result<Option<Option<Outcome>>, GraspError> {
        match work.verb {
            Verb::Reset => Ok((state.error != Flag::True).then_some(None)),
            Verb::Configure(_) | Verb::Stop => Ok(Some(None)),
            Verb::Calibrate if state.error == Flag::True => Err(GraspError::CalibrationFailed),
            Verb::Calibrate => {
                let done = state.calibrated == Flag::True && state.ready == Flag::True;
                Ok((done && state.moving != Flag::True).then_some(None))
            }
            Verb::Go(target) => {
                if (state.position - work.rest.0).abs() > STILL_PERCENT {
                    work.rest = (state.position, now);
                }
                let still = now.saturating_duration_since(work.rest.1) >= self.settle;
                if !still || state.moving == Flag::True {
                    return Ok(None);
                }
                Ok(self.verdict(work, state, target).map(Some))
            }
        }
    }

    /// What the resting fingers have met. The gripper's flags may still be those of an earlier motion; the position of the
    /// fingers tells.
    fn verdict(&self, work: &Work, state: &ElectricState, target: f64) -> Option<Outcome> {
        let closing = target <= work.begin;
        let there = (state.position - target).abs() <= 100.0 * self.parameters.dead_zone;
        let missed = state.missed == Flag::True && state.position < work.begin;
        if closing && work.task.goal != Goal::Open && state.gripping == Flag::True {
            Some(Outcome::Gripped)
        } else if work.task.goal == Goal::Close && (there || missed) {
            Some(Outcome::Missed)
        } else {
            there.then_some(Outcome::Reached)
        }
    }
}

impl Hand for Electric {
    type State = ElectricState;
    type Command = ElectricCommand;

    fn hear(&mut self, state: ElectricState, now: Instant) {
        self.sender.hear(&state);
        self.state = Some(Aged::new(state, now));
    }

    fn check(&self, now: Instant) -> Result<(), GraspError> {
        self.fresh_state(now).map(|_| ())
    }

    fn begin(&mut self, task: Task, now: Instant) -> Result<(), GraspError> {
        self.target(task.goal)?;
        let state = self.fresh_state(now)?.clone();
        let verb = self.next_verb(&state, task)?;
        self.order(verb, task, &state, now);
        Ok(())
    }

    fn step(&mut self, now: Instant) -> Result<Step<ElectricCommand>, GraspError> {
        let Some(mut work) = self.work.clone() else {
            return Ok(Step::Wait);
        };
        let state = self.fresh_state(now)?.clone();
        if !self.await_acknowledgement(&mut work, &state, now)? {
            return Ok(Step::Send(work.command));
        }
        let ended = self.ended(&mut work, &state, now)?;
        let (verb, task) = (work.verb, work.task);
        let patience_s = self.patience_s(verb);
        let took_s = now.saturating_duration_since(work.sent).as_secs_f64();
        self.work = Some(work);
        let width_m = self.gap().width_m(state.position / 100.0);
        match ended {
            None if took_s > patience_s => {
                let command = verb.name();
                Err(GraspError::NotEnded {
                    command,
                    patience_s,
                    width_m,
                })
            }
            None => Ok(Step::Wait),
            Some(Some(outcome)) => {
                self.work = None;
                Ok(Step::Done(Grasped { outcome, width_m }))
            }
            Some(None) => {
                let next = match verb {
                    Verb::Configure(_) => Verb::Go(self.target(task.goal)?),
                    _ => self.next_verb(&state, task)?,
                };
                self.order(next, task, &state, now);
                Ok(Step::Wait)
            }
        }
    }

    fn halt(&mut self) -> Option<ElectricCommand> {
        self.work = None;
        let id = self.state.as_ref()?.value.id;
        Some(self.sender.command(id, Verb::Stop))
    }

    fn width_m(&self) -> Option<f64> {
        let position = self.state.as_ref()?.value.position;
        Some(self.gap().width_m(position / 100.0))
    }
}
