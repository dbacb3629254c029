//! One motion of W2 from the first command to rest, or to the reason why not.

use std::time::{Duration, Instant};

use baxter::{Arrival, Arrived, JOINTS_PER_ARM, W2};

use crate::guard::{Guard, Refusal};
use crate::monitor::Snapshot;
use crate::parameters::Parameters;
use crate::trajectory::Trajectory;

/// Ticks by which the trajectory moves on after a stall of this process. More would be a jump of the commanded angle.
const CATCH_UP_TICKS: f64 = 2.0;

/// What to do at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Publish these angles, rad, in the robot's order.
    Command([f64; JOINTS_PER_ARM]),
    /// Nothing more: the joint is there.
    Arrived(Arrived),
}

/// Why a motion was given up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// A rule forbids to go on.
    #[error("motion stopped: {0}")]
    Refused(#[from] Refusal),
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
}

/// A motion under way. Call [`Motion::step`] at each tick, and once it returns anything but a command, drop it; never resume
/// it, since the arm may have been moved meanwhile.
#[derive(Debug, Clone)]
pub struct Motion {
    guard: Guard,
    trajectory: Trajectory,
    arrival: Arrival,
    /// Angles held by the other joints.
    start_rad: [f64; JOINTS_PER_ARM],
    joint: &'static str,
    target_rad: f64,
    following_error_max_rad: f64,
    following_patience: Duration,
    advance_max_s: f64,
    started: Instant,
    deadline: Instant,
    last_tick: Instant,
    /// When the arm was last near enough to what is commanded.
    last_followed: Instant,
    trajectory_time_s: f64,
}

impl Motion {
    /// A motion from the angles measured now to `target_rad`.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn start(
        parameters: &Parameters,
        snapshot: &Snapshot,
        target_rad: f64,
        now: Instant,
    ) -> Result<Self, Refusal> {
        let guard = Guard::new(parameters);
        let start_rad = guard.check_start(snapshot, target_rad, now)?;
        let trajectory = Trajectory::new(
            start_rad[W2],
            target_rad,
            parameters.velocity_max_rad_s,
            parameters.acceleration_max_rad_s2,
            parameters.jerk_time_s,
        );
        let allowed_s = trajectory.duration_s() + parameters.dwell_s + parameters.deadline_margin_s;
        Ok(Self {
            guard,
            trajectory,
            arrival: Arrival::new(
                target_rad,
                parameters.tolerance_rad,
                parameters.rest_velocity_rad_s,
                Duration::from_secs_f64(parameters.dwell_s),
            ),
            start_rad,
            joint: parameters.side.joint_names()[W2],
            target_rad,
            following_error_max_rad: parameters.following_error_max_rad,
            following_patience: Duration::from_secs_f64(parameters.following_patience_s),
            advance_max_s: CATCH_UP_TICKS / parameters.rate_hz,
            started: now,
            deadline: now + Duration::from_secs_f64(allowed_s),
            last_tick: now,
            last_followed: now,
            trajectory_time_s: 0.0,
        })
    }

    /// The moment at which the motion is given up.
    pub fn deadline(&self) -> Instant {
        self.deadline
    }

    /// What to do now.
    ///
    /// # Errors
    /// The robot must not move on; it does not follow; it is too late. Stop commanding.
    pub fn step(&mut self, snapshot: &Snapshot, now: Instant) -> Result<Step, MotionError> {
        let measured_rad = self.guard.check(snapshot, now)?[W2];
        let commanded_rad = self.advance(measured_rad, now);
        if self.trajectory_time_s >= self.trajectory.duration_s()
            && let Some(sample) = snapshot.joints[W2]
            && let Some(arrived) = self.arrival.observe(sample.value)
        {
            return Ok(Step::Arrived(arrived));
        }
        self.check_progress(measured_rad, commanded_rad, now)?;
        let mut angles_rad = self.start_rad;
        angles_rad[W2] = commanded_rad;
        Ok(Step::Command(angles_rad))
    }

    /// The trajectory waits for an arm that is held up: the commanded angle is never far ahead of where the arm is, so that
    /// it does not rush on when the hold-up ends.
    fn advance(&mut self, measured_rad: f64, now: Instant) -> f64 {
        let elapsed_s = now.saturating_duration_since(self.last_tick).as_secs_f64();
        self.last_tick = now;
        let commanded_rad = self.trajectory.angle_rad(self.trajectory_time_s);
        if (measured_rad - commanded_rad).abs() > self.following_error_max_rad {
            return commanded_rad;
        }
        self.last_followed = now;
        self.trajectory_time_s += elapsed_s.min(self.advance_max_s);
        self.trajectory.angle_rad(self.trajectory_time_s)
    }

    fn check_progress(
        &self,
        measured_rad: f64,
        commanded_rad: f64,
        now: Instant,
    ) -> Result<(), MotionError> {
        let joint = self.joint;
        let lagging = now.saturating_duration_since(self.last_followed);
        if lagging > self.following_patience {
            return Err(MotionError::NotFollowing {
                joint,
                measured_rad,
                commanded_rad,
                lagging_s: lagging.as_secs_f64(),
            });
        }
        if now >= self.deadline {
            let after_s = now.saturating_duration_since(self.started).as_secs_f64();
            let target_rad = self.target_rad;
            return Err(MotionError::Deadline {
                joint,
                target_rad,
                measured_rad,
                after_s,
            });
        }
        Ok(())
    }
}
