//! One motion of W2 from the first command to the rest of the arm, at its target or wherever the motion had to end.

use std::time::{Duration, Instant};

use baxter::{Arrival, Arrived, JOINTS_PER_ARM, W2, fresh};

use crate::guard::{Guard, Refusal};
use crate::monitor::Snapshot;
use crate::parameters::Parameters;
use crate::setpoints::{NoPath, RateLimits, Setpoints};

/// Pause between ticks, in periods and in seconds, after which the arm counts as held: the robot has stopped at the last
/// setpoint, and going on at speed would be a jump. The larger counts: timers are no finer than a millisecond.
const STALL_PERIODS: f64 = 3.0;
const STALL_S: f64 = 0.03;

/// Silence after which the robot may, and after which it must have left its last setpoint to hold wherever it is: its timeout
/// is 0.2 s.
const MAY_LET_GO: Duration = Duration::from_millis(150);
const LET_GO: Duration = Duration::from_millis(250);

/// Distance from the setpoint at which the arm counts as there when it comes to rest, rad.
const NEAR_RAD: f64 = 0.02;

/// How long the arm may take to come to rest once it is no longer commanded. The robot holds where it is 0.2 s after the last
/// command.
const REST_PATIENCE: Duration = Duration::from_secs(2);

/// What to do at a tick.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Publish these angles, rad, in the robot's order.
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

/// The part of a turn in which the commanded rate is constant, by the stamps of the joint states that were the newest then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConstantPart {
    /// When it began, ROS time.
    pub from: Duration,
    /// When it ended, ROS time.
    pub until: Duration,
}

/// The end of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// At the target, or why not.
    pub result: Result<Arrived, MotionError>,
    /// Where and since when the arm rests; `None` where it was not seen at rest within 2 s.
    pub rest: Option<Arrived>,
    /// The last part at a constant rate that nothing interrupted; `None` where the rate was never reached.
    pub constant: Option<ConstantPart>,
}

/// Why a motion ended before its target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A rule forbids to go on.
    #[error("motion stopped: {0}")]
    Refused(#[from] Refusal),
    /// Something is not heard, or was not listened to.
    #[error(
        "motion stopped: {refusal}; this computer did not get to run for {stalled_s:.2} s: it is too busy"
    )]
    Stalled {
        /// What is old.
        refusal: Refusal,
        /// Time between two ticks, s.
        stalled_s: f64,
    },
    /// The arm is elsewhere than it was told.
    #[error(
        "motion stopped: {joint} is at {measured_rad:.3} rad when {commanded_rad:.3} was commanded, and has been \
         no nearer for {lagging_s:.1} s: the arm is blocked, slower than the speed ratio asked for, or does not \
         receive its commands"
    )]
    NotFollowing {
        /// Joint.
        joint: &'static str,
        /// Where it is.
        measured_rad: f64,
        /// Where it should be.
        commanded_rad: f64,
        /// How long it has been too far behind.
        lagging_s: f64,
    },
    /// Too late.
    #[error(
        "motion stopped: {joint} is not at rest at {target_rad:.3} rad after {after_s:.1} s; it is at \
         {measured_rad:.3} rad"
    )]
    Deadline {
        /// Joint.
        joint: &'static str,
        /// Where it should be.
        target_rad: f64,
        /// Where it is.
        measured_rad: f64,
        /// Time since the start.
        after_s: f64,
    },
    /// Somebody called `stop_wrist`.
    #[error("motion stopped: stop_wrist was called")]
    Stopped,
    /// Whoever asked no longer waits; in words.
    #[error("motion stopped: {0}")]
    NobodyWaits(String),
    /// The generator of setpoints failed.
    #[error("motion stopped: {0}")]
    NoPath(#[from] NoPath),
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

/// The last command, rad, where the robot may still hold the arm there: the next has to go on from it, not from the measured
/// angles, which differ a little.
fn in_force(
    snapshot: &Snapshot,
    measured_rad: &[f64; JOINTS_PER_ARM],
    now: Instant,
) -> Option<[f64; JOINTS_PER_ARM]> {
    let last_rad = fresh(snapshot.commanded.as_ref(), LET_GO, now).ok()?;
    let is_near = |(last, measured): (&f64, &f64)| (last - measured).abs() <= NEAR_RAD;
    last_rad
        .iter()
        .zip(measured_rad)
        .all(is_near)
        .then_some(*last_rad)
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
        let held_rad = in_force(snapshot, &measured_rad, now).unwrap_or(measured_rad);
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
            held_rad,
            joint: parameters.side.joint_names()[W2],
            target_rad,
            following_error_max_rad: parameters.following_error_max_rad,
            following_patience: Duration::from_secs_f64(parameters.following_patience_s),
            stall: Duration::from_secs_f64(STALL_S.max(STALL_PERIODS * period_s)),
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

    /// Ends the motion for a reason from outside, along a ramp. The first reason counts.
    pub fn end(&mut self, reason: MotionError, now: Instant) {
        if !matches!(self.phase, Phase::Turning | Phase::Held) {
            return;
        }
        self.phase = match self.setpoints.come_to_rest(&self.stop_limits) {
            Ok(()) => Phase::Ramp(reason),
            Err(_) => Phase::Settling(reason, now),
        };
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
                Err(MotionError::Refused(refusal))
                    if elapsed > self.stall && refusal.is_of_silence() =>
                {
                    let stalled_s = elapsed.as_secs_f64();
                    self.end(MotionError::Stalled { refusal, stalled_s }, now);
                }
                Err(reason) => self.end(reason, now),
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

    /// After ticks that did not come the robot rests at the last setpoint; from there the motion goes on as from any rest.
    /// Unless the robot may have let go of a setpoint at which the arm is not: it would jump there.
    fn resume_after_stall(&mut self, stalled: Duration, snapshot: &Snapshot, now: Instant) {
        let setpoint_rad = self.setpoints.now().angle_rad;
        self.setpoints.rest_at(setpoint_rad);
        let measured_rad = snapshot.joints[W2].map_or(f64::NAN, |sample| sample.value.angle_rad);
        let is_near = (measured_rad - setpoint_rad).abs() <= NEAR_RAD;
        match &self.phase {
            Phase::Turning | Phase::Held if stalled > MAY_LET_GO && !is_near => {
                let reason = MotionError::NotFollowing {
                    joint: self.joint,
                    measured_rad,
                    commanded_rad: setpoint_rad,
                    lagging_s: stalled.as_secs_f64(),
                };
                self.phase = Phase::Settling(reason, now);
            }
            Phase::Turning | Phase::Held => self.phase = Phase::Held,
            Phase::Ramp(reason) if stalled > MAY_LET_GO => {
                self.phase = Phase::Settling(reason.clone(), now);
            }
            Phase::Ramp(_) | Phase::Settling(..) => {}
        }
    }

    /// One tick of an end before the target.
    fn come_to_rest(&mut self, snapshot: &Snapshot, now: Instant) -> Step {
        if let Phase::Ramp(reason) = &self.phase {
            let taken = self.guard.check_commands_taken(snapshot, now).is_ok();
            let settling = Phase::Settling(reason.clone(), now);
            if taken {
                let last = self.command();
                if self.setpoints.is_resting() {
                    self.phase = settling;
                }
                return last;
            }
            self.phase = settling;
        }
        let Phase::Settling(reason, since) = &self.phase else {
            return Step::Wait;
        };
        let settling = now.saturating_duration_since(*since);
        let setpoint_rad = self.setpoints.now().angle_rad;
        let rest = snapshot.joints[W2]
            .and_then(|sample| self.rest.observe(sample.value))
            // An arm that is blocked short of its setpoint would go on if it came free.
            .filter(|at| (at.angle_rad - setpoint_rad).abs() <= NEAR_RAD || settling > LET_GO);
        if rest.is_none() && settling <= REST_PATIENCE {
            return Step::Wait;
        }
        let result = Err(reason.clone());
        let constant = self.constant;
        Step::Ended(Ended {
            result,
            rest,
            constant,
        })
    }

    fn command(&mut self) -> Step {
        let mut angles_rad = self.held_rad;
        angles_rad[W2] = self.setpoints.advance().angle_rad;
        Step::Command(angles_rad)
    }
}
