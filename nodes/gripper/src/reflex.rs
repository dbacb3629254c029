//! A ReFlex hand: three tendon-driven fingers, controlled by position.
//!
//! Force control by position commands, which are all that the hand's driver takes: the commanded angles advance slowly and
//! stop when a motor's load shows contact.

use std::time::{Duration, Instant};

use baxter::Aged;

use crate::error::GraspError;
use crate::hand::{Goal, Grasped, Hand, Outcome, Step, Task, fresh_state};
use crate::parameters::{Parameters, ReflexParameters};

/// Fingers of the hand; f3 is opposite to f1 and f2.
pub const FINGERS: usize = 3;

/// Share of the requested load from which a finger counts as in contact.
const CONTACT_SHARE: f64 = 0.5;
/// A finger backs off above this multiple of the requested load, which a fast contact can cause.
const LOAD_EXCESS: f64 = 1.15;
/// Share of the speed with which a finger in contact increases its load.
const CREEP_SHARE: f64 = 0.1;
/// Period of commands: the driver's own loop runs at 30 Hz.
const SEND_PERIOD: Duration = Duration::from_millis(33);
/// A finger counts as still if its angle changes by less than this.
const STILL_RAD: f64 = 0.02;
/// Longest delay of this process for which the motion catches up in one step.
const CATCH_UP_MAX: Duration = Duration::from_millis(100);

/// State of one finger, from `reflex_msgs/Hand`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FingerState {
    /// Angle, rad; 0 is open.
    pub angle_rad: f64,
    /// Load of its motor, in the driver's unit.
    pub load: f64,
}

/// The fields of `reflex_msgs/PoseCommand`, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseCommand {
    /// Angles of the fingers.
    pub fingers_rad: [f64; FINGERS],
    /// Turn of f1 and f2 about their bases.
    pub preshape_rad: f64,
}

/// The client of a ReFlex hand.
#[derive(Debug, Clone)]
pub struct Reflex {
    parameters: ReflexParameters,
    topic: String,
    state_age_max: Duration,
    settle: Duration,
    motion_patience: Duration,
    state: Option<Aged<[FingerState; FINGERS]>>,
    /// Last commanded angles. While an object is held they are ahead of the measured ones, which makes the grip force.
    commanded_rad: Option<[f64; FINGERS]>,
    work: Option<Work>,
}

#[derive(Debug, Clone, Copy)]
struct Work {
    goal: Goal,
    target_rad: f64,
    load_stop: f64,
    begun: Instant,
    stepped: Instant,
    sent: Option<Instant>,
    rest_rad: [f64; FINGERS],
    rest_since: Instant,
}

impl Reflex {
    /// A client with the node's parameters.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            parameters: parameters.reflex.clone(),
            topic: format!("{}/hand_state", parameters.reflex_base()),
            state_age_max: Duration::from_secs_f64(parameters.state_age_max_s),
            settle: Duration::from_secs_f64(parameters.settle_s),
            motion_patience: Duration::from_secs_f64(parameters.motion_patience_s),
            state: None,
            commanded_rad: None,
            work: None,
        }
    }

    fn fresh_state(&self, now: Instant) -> Result<[FingerState; FINGERS], GraspError> {
        fresh_state(self.state.as_ref(), self.state_age_max, &self.topic, now).copied()
    }

    fn target_rad(&self, goal: Goal) -> Result<f64, GraspError> {
        let max_m = self.parameters.open_width_m;
        match goal {
            Goal::Open => Ok(0.0),
            Goal::Close => Ok(self.parameters.closed_rad),
            Goal::Width(width_m) if width_m <= max_m => {
                Ok(self.parameters.closed_rad * (1.0 - width_m / max_m))
            }
            Goal::Width(width_m) => Err(GraspError::WidthOutside {
                width_m,
                min_m: 0.0,
                max_m,
            }),
        }
    }

    /// The next commanded angle of a finger. Opening moves at full speed; closing slows down in contact until the load is
    /// reached. The command never leads the measured angle by more than `lead_max_rad`.
    fn advance(&self, commanded_rad: f64, finger: FingerState, work: &Work, dt_s: f64) -> f64 {
        let (step_rad, lead_rad) = (
            self.parameters.speed_rad_s * dt_s,
            self.parameters.lead_max_rad,
        );
        if work.target_rad < commanded_rad {
            let next_rad = (commanded_rad - step_rad).max(work.target_rad);
            return next_rad.max(finger.angle_rad - lead_rad).min(commanded_rad);
        }
        let pressed = finger.load / work.load_stop;
        if pressed > LOAD_EXCESS {
            return (commanded_rad - CREEP_SHARE * step_rad)
                .max(finger.angle_rad.min(commanded_rad));
        }
        if pressed >= 1.0 {
            return commanded_rad;
        }
        let share = if pressed < CONTACT_SHARE {
            1.0
        } else {
            CREEP_SHARE
        };
        let next_rad = (commanded_rad + share * step_rad).min(work.target_rad);
        next_rad.min(finger.angle_rad + lead_rad).max(commanded_rad)
    }

    /// What the resting fingers have met.
    fn verdict(
        &self,
        fingers: &[FingerState; FINGERS],
        commanded_rad: &[f64; FINGERS],
        work: &Work,
    ) -> Result<Outcome, GraspError> {
        let mut holding = Vec::new();
        for (index, finger) in fingers.iter().enumerate() {
            if (finger.angle_rad - work.target_rad).abs() <= self.parameters.tolerance_rad {
                continue;
            }
            let short = finger.angle_rad < work.target_rad;
            if !short || finger.load < CONTACT_SHARE * work.load_stop {
                return Err(GraspError::NotFollowing {
                    finger: index + 1,
                    measured_rad: finger.angle_rad,
                    commanded_rad: commanded_rad[index],
                });
            }
            holding.push(index + 1);
        }
        match holding[..] {
            [] if work.goal == Goal::Close => Ok(Outcome::Missed),
            [] => Ok(Outcome::Reached),
            [finger] => Err(GraspError::OneFinger { finger }),
            _ => Ok(Outcome::Gripped),
        }
    }

    fn pose(&self, fingers_rad: [f64; FINGERS]) -> PoseCommand {
        PoseCommand {
            fingers_rad,
            preshape_rad: self.parameters.preshape_rad,
        }
    }
}

impl Hand for Reflex {
    type State = [FingerState; FINGERS];
    type Command = PoseCommand;

    fn hear(&mut self, state: Self::State, now: Instant) {
        // Ignore a message with an angle or load that is not finite; without fresh ones the hand counts as silent.
        if state
            .iter()
            .all(|finger| finger.angle_rad.is_finite() && finger.load.is_finite())
        {
            self.state = Some(Aged::new(state, now));
        }
    }

    fn check(&self, now: Instant) -> Result<(), GraspError> {
        self.fresh_state(now).map(|_| ())
    }

    fn begin(&mut self, task: Task, now: Instant) -> Result<(), GraspError> {
        let target_rad = self.target_rad(task.goal)?;
        let fingers = self.fresh_state(now)?;
        let measured_rad = fingers.map(|finger| finger.angle_rad);
        let lead_rad = self.parameters.lead_max_rad;
        // Start from the last commanded angles, not the measured ones: otherwise a held object would be let go.
        let still_valid = |commanded: &[f64; FINGERS]| {
            let mut pairs = commanded.iter().zip(&measured_rad);
            pairs.all(|(commanded, measured)| (commanded - measured).abs() <= lead_rad)
        };
        self.commanded_rad = self
            .commanded_rad
            .filter(still_valid)
            .or(Some(measured_rad));
        self.work = Some(Work {
            goal: task.goal,
            target_rad,
            load_stop: self.parameters.load_max * task.force.unwrap_or(self.parameters.force),
            begun: now,
            stepped: now,
            sent: None,
            rest_rad: measured_rad,
            rest_since: now,
        });
        Ok(())
    }

    fn step(&mut self, now: Instant) -> Result<Step<PoseCommand>, GraspError> {
        let (Some(mut work), Some(before_rad)) = (self.work, self.commanded_rad) else {
            return Ok(Step::Wait);
        };
        let fingers = self.fresh_state(now)?;
        let dt = now
            .saturating_duration_since(work.stepped)
            .min(CATCH_UP_MAX);
        work.stepped = now;
        let mut commanded_rad = before_rad;
        for (commanded, finger) in commanded_rad.iter_mut().zip(fingers) {
            *commanded = self.advance(*commanded, finger, &work, dt.as_secs_f64());
        }
        self.commanded_rad = Some(commanded_rad);
        let measured_rad = fingers.map(|finger| finger.angle_rad);
        let moved = |a: &[f64; FINGERS], b: &[f64; FINGERS]| {
            a.iter().zip(b).any(|(a, b)| (a - b).abs() > STILL_RAD)
        };
        if commanded_rad != before_rad || moved(&measured_rad, &work.rest_rad) {
            (work.rest_rad, work.rest_since) = (measured_rad, now);
        }
        if now.saturating_duration_since(work.rest_since) >= self.settle {
            self.work = None;
            let outcome = self.verdict(&fingers, &commanded_rad, &work)?;
            let width_m = self
                .parameters
                .width_m(measured_rad.iter().sum::<f64>() / FINGERS as f64);
            return Ok(Step::Done(Grasped { outcome, width_m }));
        }
        if now.saturating_duration_since(work.begun) > self.motion_patience {
            let patience_s = self.motion_patience.as_secs_f64();
            return Err(GraspError::Restless { patience_s });
        }
        let due = work
            .sent
            .is_none_or(|sent| now.saturating_duration_since(sent) >= SEND_PERIOD);
        if due {
            work.sent = Some(now);
        }
        self.work = Some(work);
        Ok(if due {
            Step::Send(self.pose(commanded_rad))
        } else {
            Step::Wait
        })
    }

    /// Commands the measured angles, or, if the fingers hold something, the commanded angles that hold it.
    fn halt(&mut self) -> Option<PoseCommand> {
        let work = self.work.take()?;
        let fingers = self.state?.value;
        let commanded_rad = self.commanded_rad?;
        let mut held_rad = fingers.map(|finger| finger.angle_rad);
        for ((held, finger), commanded) in held_rad.iter_mut().zip(fingers).zip(commanded_rad) {
            if finger.load >= CONTACT_SHARE * work.load_stop {
                *held = commanded;
            }
        }
        self.commanded_rad = Some(held_rad);
        Some(self.pose(held_rad))
    }

    fn width_m(&self) -> Option<f64> {
        let fingers = self.state?.value;
        let mean_rad = fingers.iter().map(|finger| finger.angle_rad).sum::<f64>() / FINGERS as f64;
        Some(self.parameters.width_m(mean_rad))
    }
}
