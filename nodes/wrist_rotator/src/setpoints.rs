//! The commanded angle from one tick to the next: never beyond its limits of velocity, acceleration and jerk.

use rsruckig::prelude::{
    ControlInterface, InputParameter, Ruckig, RuckigError, ThrowErrorHandler, Trajectory,
};

/// Largest rates of change of a commanded angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateLimits {
    /// rad/s.
    pub velocity_rad_s: f64,
    /// rad/s².
    pub acceleration_rad_s2: f64,
    /// rad/s³.
    pub jerk_rad_s3: f64,
}

/// The commanded angle and its rates of change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint {
    /// rad.
    pub angle_rad: f64,
    /// rad/s.
    pub velocity_rad_s: f64,
    /// rad/s².
    pub acceleration_rad_s2: f64,
}

/// No path within the limits was found, though there is one from any state: a defect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("no path from {from_rad:.3} rad: {reason}")]
pub struct NoPath {
    from_rad: f64,
    reason: String,
}

/// Generates setpoints for one joint, one each period. It knows nothing of the time of day: a period in which it is not
/// asked leaves the setpoint where it is.
///
/// The paths are those of Ruckig (Berscheid and Kröger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target
/// States", RSS 2021) in the port rsruckig, rather than own ones: it starts from any velocity and acceleration, which a stop
/// in the middle of a motion needs, and it is the fastest within the limits.
#[derive(Debug, Clone)]
pub struct Setpoints {
    period_s: f64,
    now: Setpoint,
    path: Trajectory<1>,
    path_time_s: f64,
}

impl Setpoint {
    /// At rest.
    pub fn at_rest(angle_rad: f64) -> Self {
        Self {
            angle_rad,
            velocity_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
        }
    }

    /// Whether it moves at the largest velocity, and so at a constant one.
    pub fn is_cruising(&self, limits: &RateLimits) -> bool {
        const ROUNDING: f64 = 1e-9;
        self.velocity_rad_s.abs() >= limits.velocity_rad_s - ROUNDING
    }
}

impl Setpoints {
    /// At rest at `angle_rad`.
    pub fn at_rest(angle_rad: f64, period_s: f64) -> Self {
        Self {
            period_s,
            now: Setpoint::at_rest(angle_rad),
            path: Trajectory::new(None),
            path_time_s: 0.0,
        }
    }

    /// The last setpoint.
    pub fn now(&self) -> Setpoint {
        self.now
    }

    /// Whether the setpoint has come to rest where it was to go.
    pub fn is_resting(&self) -> bool {
        self.path_time_s >= self.path.get_duration()
    }

    /// Time until it rests, s.
    pub fn remaining_s(&self) -> f64 {
        (self.path.get_duration() - self.path_time_s).max(0.0)
    }

    /// Goes to `target_rad` from now on, and rests there.
    ///
    /// # Errors
    /// No path was found; the setpoint goes where it went.
    pub fn go_to(&mut self, target_rad: f64, limits: &RateLimits) -> Result<(), NoPath> {
        self.plan(limits, |input| {
            input.control_interface = ControlInterface::Position;
            input.target_position[0] = target_rad;
        })
    }

    /// Comes to rest from now on, as soon as the limits allow.
    ///
    /// # Errors
    /// No path was found; the setpoint goes where it went.
    pub fn come_to_rest(&mut self, limits: &RateLimits) -> Result<(), NoPath> {
        self.plan(limits, |input| {
            input.control_interface = ControlInterface::Velocity;
            input.target_velocity[0] = 0.0;
        })
    }

    /// Rests at `angle_rad` from now on.
    pub fn rest_at(&mut self, angle_rad: f64) {
        *self = Self::at_rest(angle_rad, self.period_s);
    }

    /// The setpoint of the next period.
    pub fn advance(&mut self) -> Setpoint {
        if self.is_resting() {
            return self.now;
        }
        self.path_time_s += self.period_s;
        // The end exactly, not what rounding leaves of the velocity there.
        let time_s = self.path_time_s.min(self.path.get_duration());
        let [mut angle_rad, mut velocity_rad_s, mut acceleration_rad_s2] =
            std::array::from_fn(|_| rsruckig::daov_stack![0.0]);
        self.path.at_time(
            time_s,
            &mut Some(&mut angle_rad),
            &mut Some(&mut velocity_rad_s),
            &mut Some(&mut acceleration_rad_s2),
            &mut None,
            &mut None,
        );
        self.now = Setpoint {
            angle_rad: angle_rad[0],
            velocity_rad_s: velocity_rad_s[0],
            acceleration_rad_s2: acceleration_rad_s2[0],
        };
        if self.is_resting() {
            self.now = Setpoint::at_rest(self.now.angle_rad);
        }
        self.now
    }

    fn plan(
        &mut self,
        limits: &RateLimits,
        aim: impl FnOnce(&mut InputParameter<1>),
    ) -> Result<(), NoPath> {
        let mut input = InputParameter::new(None);
        input.current_position[0] = self.now.angle_rad;
        input.current_velocity[0] = self.now.velocity_rad_s;
        input.current_acceleration[0] = self.now.acceleration_rad_s2;
        input.max_velocity[0] = limits.velocity_rad_s;
        input.max_acceleration[0] = limits.acceleration_rad_s2;
        input.max_jerk[0] = limits.jerk_rad_s3;
        aim(&mut input);
        let mut path = Trajectory::new(None);
        let mut planner = Ruckig::<1, ThrowErrorHandler>::new(None, self.period_s);
        let planned = planner.calculate(&input, &mut path);
        planned.map_err(|error: RuckigError| NoPath {
            from_rad: self.now.angle_rad,
            reason: error.to_string(),
        })?;
        (self.path, self.path_time_s) = (path, 0.0);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
