//! One motion of W2 from the first command to the rest of the arm, at its target or wherever the motion had to end.

mod ended;
mod rest;

use std::time::{Duration, Instant};

use baxter::{Arrival, JOINTS_PER_ARM, W2};

use crate::guard::Guard;
use crate::monitor::Snapshot;
use crate::parameters::Parameters;
use crate::setpoints::{NoPath, RateLimits, Setpoints};
pub use ended::{ConstantPart, Ended, MotionError};

/// What to do at a tick.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Publish these angles, rad, in the robot's order, if [`Motion::may_send`] agrees.
    Command([f64; JOINTS_PER_ARM]),
    /// Publish nothing, and ask again: the arm comes to rest.
    Wait,
    /// Nothing more.
    Ended(Ended),
}

/// Where to turn, and how fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Where W2 is to rest, rad.
    pub target_rad: f64,
    /// Rate between the ramps, rad/s; `None`: as fast as the parameters allow.
    pub rate_rad_s: Option<f64>,
}

impl From<f64> for Turn {
    fn from(target_rad: f64) -> Self {
        Self {
            target_rad,
            rate_rad_s: None,
        }
    }
}

/// A motion under way. Call [`Motion::step`] at each tick until it says that the motion has ended; then drop it.
#[derive(Debug, Clone)]
pub struct Motion {
    guard: Guard,
    limits: RateLimits,
    stop_limits: RateLimits,
    setpoints: Setpoints,
    phase: Phase,
    arrival: Arrival,
    rest: Arrival,
    constant: Option<ConstantPart>,
    /// Angles held by the other joints, rad.
    held_rad: [f64; JOINTS_PER_ARM],
    /// W2 in the command before the last one, rad.
    before_rad: f64,
    joint: &'static str,
    target_rad: f64,
    following_error_max_rad: f64,
    following_patience: Duration,
    stall: Duration,
    started: Instant,
    deadline: Instant,
    last_tick: Instant,
    /// When the arm was last near enough to what is commanded.
    last_followed: Instant,
}

#[derive(Debug, Clone)]
enum Phase {
    /// The setpoint is on its way to the target, or rests there.
    Turning,
    /// The setpoint comes to rest, and rests, until the arm has come near again.
    Held,
    /// The setpoint comes to rest for good.
    Ramp(MotionError),
    /// No more setpoints: the arm comes to rest.
    Settling(MotionError, Instant),
}

impl Motion {
    /// A motion from the angles measured now to the turn's target.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn start(
        parameters: &Parameters,
        snapshot: &Snapshot,
        turn: impl Into<Turn>,
        now: Instant,
    ) -> Result<Self, MotionError> {
        let Turn {
            target_rad,
            rate_rad_s,
        } = turn.into();
        let guard = Guard::new(parameters);
        let measured_rad = guard.check_start(snapshot, target_rad, now)?;
        guard.check_rate(rate_rad_s)?;
        let held_rad = rest::in_force(snapshot, &measured_rad, now).unwrap_or(measured_rad);
        let period_s = 1.0 / parameters.rate_hz;
        let mut setpoints = Setpoints::at_rest(held_rad[W2], period_s);
        let (mut limits, stop_limits) = (parameters.limits(), parameters.stop_limits());
        limits.velocity_rad_s = rate_rad_s.unwrap_or(limits.velocity_rad_s);
        setpoints.go_to(target_rad, &limits)?;
        let allowed_s = setpoints.remaining_s() + parameters.dwell_s + parameters.deadline_margin_s;
        let dwell = Duration::from_secs_f64(parameters.dwell_s);
        let rest_velocity_rad_s = parameters.rest_velocity_rad_s;
        let tolerance_rad = parameters.tolerance_rad;
        Ok(Self {
            guard,
            limits,
            stop_limits,
            setpoints,
            phase: Phase::Turning,
            arrival: Arrival::new(target_rad, tolerance_rad, rest_velocity_rad_s, dwell),
            rest: Arrival::anywhere(rest_velocity_rad_s, dwell),
            constant: None,
            before_rad: held_rad[W2],
            held_rad,
            joint: parameters.side.joint_names()[W2],
            target_rad,
            following_error_max_rad: parameters.following_error_max_rad,
            following_patience: Duration::from_secs_f64(parameters.following_patience_s),
            stall: rest::stall(period_s),
            started: now,
            deadline: now + Duration::from_secs_f64(allowed_s),
            last_tick: now,
            last_followed: now,
        })
    }

    /// The moment at which the motion is given up.
    pub fn deadline(&self) -> Instant {
        self.deadline
    }

    /// Why the motion is coming to an end before its target, if it is.
    pub fn ending(&self) -> Option<&MotionError> {
        match &self.phase {
            Phase::Turning | Phase::Held => None,
            Phase::Ramp(reason) | Phase::Settling(reason, _) => Some(reason),
        }
    }

    /// What to do now.
    pub fn step(&mut self, snapshot: &Snapshot, now: Instant) -> Step {
        let elapsed = now.saturating_duration_since(self.last_tick);
        self.last_tick = now;
        if elapsed > self.stall {
            self.resume_after_stall(elapsed, snapshot, now);
        }
        if matches!(self.phase, Phase::Turning | Phase::Held) {
            match self.turn(snapshot, now) {
                Ok(step) => return step,
                Err(reason) => self.end(self.blame_stall(reason, elapsed), now),
            }
        }
        self.come_to_rest(snapshot, now)
    }

    /// One tick towards the target.
    fn turn(&mut self, snapshot: &Snapshot, now: Instant) -> Result<Step, MotionError> {
        let measured_rad = self.guard.check(snapshot, now)?[W2];
        let at_target = matches!(self.phase, Phase::Turning) && self.setpoints.is_resting();
        if at_target
            && let Some(sample) = snapshot.joints[W2]
            && let Some(arrived) = self.arrival.observe(sample.value)
        {
            return Ok(Step::Ended(Ended {
                result: Ok(arrived),
                rest: Some(arrived),
                constant: self.constant,
            }));
        }
        self.follow(measured_rad, now)?;
        self.check_progress(measured_rad, now)?;
        let command = self.command();
        self.note_rate(snapshot);
        Ok(command)
    }

    /// Follows the part of the turn at its constant rate.
    fn note_rate(&mut self, snapshot: &Snapshot) {
        let is_turning = matches!(self.phase, Phase::Turning);
        match snapshot.joints[W2] {
            Some(sample) if is_turning && self.setpoints.now().is_cruising(&self.limits) => {
                let until = sample.value.stamp;
                let from = self.constant.map_or(until, |constant| constant.from);
                self.constant = Some(ConstantPart { from, until });
            }
            // What comes after an interruption counts.
            _ if !is_turning => self.constant = None,
            _ => {}
        }
    }

    /// The setpoint waits for an arm that is held up: it is never far ahead of where the arm is, so that the arm does not
    /// rush on when the hold-up ends.
    fn follow(&mut self, measured_rad: f64, now: Instant) -> Result<(), NoPath> {
        let ahead_rad = (self.setpoints.now().angle_rad - measured_rad).abs();
        let follows = ahead_rad <= self.following_error_max_rad;
        if follows {
            self.last_followed = now;
        }
        match self.phase {
            Phase::Turning if !follows => {
                self.setpoints.come_to_rest(&self.stop_limits)?;
                self.phase = Phase::Held;
            }
            // A hold ends at rest, whence the target is reached without overshoot.
            Phase::Held if follows && self.setpoints.is_resting() => {
                self.setpoints.go_to(self.target_rad, &self.limits)?;
                self.phase = Phase::Turning;
            }
            _ => {}
        }
        Ok(())
    }

    fn check_progress(&self, measured_rad: f64, now: Instant) -> Result<(), MotionError> {
        let joint = self.joint;
        let lagging = now.saturating_duration_since(self.last_followed);
        if lagging > self.following_patience {
            return Err(MotionError::NotFollowing {
                joint,
                measured_rad,
                commanded_rad: self.setpoints.now().angle_rad,
                lagging_s: lagging.as_secs_f64(),
            });
        }
        if now >= self.deadline {
            return Err(MotionError::Deadline {
                joint,
                target_rad: self.target_rad,
                measured_rad,
                after_s: now.saturating_duration_since(self.started).as_secs_f64(),
            });
        }
        Ok(())
    }

    /// Whether the command of the last [`Motion::step`] may still be sent at `now`. If this computer did not get to run since
    /// that step, the robot has stopped at the command before, and this one, at speed, would be a jump: it is taken back, and
    /// the motion goes on from rest.
    pub fn may_send(&mut self, now: Instant) -> bool {
        let is_prompt = now.saturating_duration_since(self.last_tick) <= self.stall;
        if !is_prompt {
            self.setpoints.rest_at(self.before_rad);
            if matches!(self.phase, Phase::Turning) {
                self.phase = Phase::Held;
            }
        }
        is_prompt
    }

    fn command(&mut self) -> Step {
        self.before_rad = self.setpoints.now().angle_rad;
        let mut angles_rad = self.held_rad;
        angles_rad[W2] = self.setpoints.advance().angle_rad;
        Step::Command(angles_rad)
    }
}
