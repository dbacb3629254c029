//! Whether the robot allows its gripper to move.

use std::time::{Duration, Instant};

use crate::error::GraspError;

/// What counts of `/robot/state`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotState {
    /// Joints are powered.
    pub enabled: bool,
    /// Stopped by button, software or fault.
    pub stopped: bool,
}

/// The robot's last word.
#[derive(Debug, Clone)]
pub struct RobotWatch {
    age_max: Duration,
    last: Option<(RobotState, Instant)>,
}

impl RobotWatch {
    /// What is older than `age_max_s` does not count.
    pub fn new(age_max_s: f64) -> Self {
        Self {
            age_max: Duration::from_secs_f64(age_max_s),
            last: None,
        }
    }

    /// Takes a `/robot/state` message.
    pub fn hear(&mut self, state: RobotState, now: Instant) {
        self.last = Some((state, now));
    }

    /// May the gripper move?
    ///
    /// # Errors
    /// The robot is silent, stopped or not enabled.
    pub fn check(&self, now: Instant) -> Result<(), GraspError> {
        let (state, heard) = self.last.ok_or(GraspError::RobotAbsent)?;
        let age = now.saturating_duration_since(heard);
        if age > self.age_max {
            let (age_s, max_s) = (age.as_secs_f64(), self.age_max.as_secs_f64());
            return Err(GraspError::RobotStale { age_s, max_s });
        }
        match state {
            RobotState { stopped: true, .. } => Err(GraspError::RobotStopped),
            RobotState { enabled: false, .. } => Err(GraspError::RobotNotEnabled),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_robot_that_is_enabled_and_heard_lets_its_gripper_move() {
        let (mut robot, now) = (RobotWatch::new(0.5), Instant::now());
        assert_eq!(robot.check(now), Err(GraspError::RobotAbsent));
        let state = |enabled, stopped| RobotState { enabled, stopped };
        robot.hear(state(true, false), now);
        assert_eq!(robot.check(now), Ok(()));
        let later = now + Duration::from_secs(1);
        assert!(matches!(
            robot.check(later),
            Err(GraspError::RobotStale { .. })
        ));
        robot.hear(state(false, false), now);
        assert_eq!(robot.check(now), Err(GraspError::RobotNotEnabled));
        robot.hear(state(false, true), now);
        assert_eq!(robot.check(now), Err(GraspError::RobotStopped));
    }
}
