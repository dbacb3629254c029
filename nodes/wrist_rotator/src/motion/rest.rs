//! How a motion comes to rest before its target: along a ramp while the robot takes commands, then without commands until the
//! arm rests. And what a pause between ticks makes of a motion.

use std::time::{Duration, Instant};

use baxter::{JOINTS_PER_ARM, W2, fresh};

use super::{Ended, Motion, MotionError, Phase, Step};
use crate::monitor::Snapshot;

/// Silence after which the robot may, and after which it must have left its last setpoint to hold wherever it is: its timeout
/// is 0.2 s.
const MAY_LET_GO: Duration = Duration::from_millis(150);
const LET_GO: Duration = Duration::from_millis(250);

/// Distance from the setpoint at which the arm counts as there when it comes to rest, rad.
const NEAR_RAD: f64 = 0.02;

/// How long the arm may take to come to rest once it is no longer commanded. The robot holds where it is 0.2 s after the last
/// command.
const REST_PATIENCE: Duration = Duration::from_secs(2);

/// Pause between ticks after which the arm counts as held: the robot has stopped at the last setpoint, and going on at speed
/// would be a jump. Three periods, but at least 0.03 s, since timers are no finer than a millisecond.
pub(super) fn stall(period_s: f64) -> Duration {
    const STALL_PERIODS: f64 = 3.0;
    const STALL_S: f64 = 0.03;
    Duration::from_secs_f64(STALL_S.max(STALL_PERIODS * period_s))
}

/// The last command, rad, where the robot may still hold the arm there: the next has to go on from it, not from the measured
/// angles, which differ a little.
pub(super) fn in_force(
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

impl Motion {
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

    /// After ticks that did not come the robot rests at the last setpoint, and the motion goes on from there as from any rest.
    /// It ends if the robot may have let go of that setpoint while the arm was elsewhere: the arm would jump there.
    pub(super) fn resume_after_stall(
        &mut self,
        stalled: Duration,
        snapshot: &Snapshot,
        now: Instant,
    ) {
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

    /// Where something was not heard because this computer did not run, says so.
    pub(super) fn blame_stall(&self, reason: MotionError, elapsed: Duration) -> MotionError {
        match reason {
            MotionError::Refused(refusal) if elapsed > self.stall && refusal.is_of_silence() => {
                let stalled_s = elapsed.as_secs_f64();
                MotionError::Stalled { refusal, stalled_s }
            }
            other => other,
        }
    }

    /// One tick of an end before the target.
    pub(super) fn come_to_rest(&mut self, snapshot: &Snapshot, now: Instant) -> Step {
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
        Step::Ended(Ended {
            result: Err(reason.clone()),
            rest,
            constant: self.constant,
        })
    }
}
