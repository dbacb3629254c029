//! How one joint moves towards what it is told: never faster than its limit, never with more than its acceleration.

use crate::urdf::Limits;

/// Time constant with which a joint closes in on its target, seconds.
const CLOSING_S: f64 = 0.01;

/// What a joint is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Goal {
    /// Brake, then stay.
    Hold,
    /// Go there at no more than the fraction `speed` of the joint's velocity limit.
    Position { target: f64, speed: f64 },
    /// Keep that velocity until a limit is near.
    Velocity(f64),
}

/// One joint: rad and rad/s.
#[derive(Debug, Clone)]
pub(crate) struct Tracker {
    pub position: f64,
    pub velocity: f64,
    pub limits: Limits,
    acceleration_max: f64,
    /// Blocked where it is.
    pub jammed: bool,
}

impl Tracker {
    pub fn new(position: f64, limits: Limits, acceleration_max: f64) -> Self {
        Self {
            position: limits.clip(position),
            velocity: 0.0,
            limits,
            acceleration_max,
            jammed: false,
        }
    }

    pub fn step(&mut self, goal: Goal, dt_s: f64) {
        if self.jammed {
            self.velocity = 0.0;
            return;
        }
        let wanted = match goal {
            Goal::Hold => 0.0,
            Goal::Position { target, speed } => {
                let distance = self.limits.clip(target) - self.position;
                let speed_max = self.limits.velocity * speed;
                self.approach(distance).clamp(-speed_max, speed_max)
            }
            Goal::Velocity(velocity) => {
                let lowest = self.approach(self.limits.lower - self.position);
                let highest = self.approach(self.limits.upper - self.position);
                let speed_max = self.limits.velocity;
                velocity
                    .clamp(lowest.min(0.0), highest.max(0.0))
                    .clamp(-speed_max, speed_max)
            }
        };
        let change_max = self.acceleration_max * dt_s;
        self.velocity += (wanted - self.velocity).clamp(-change_max, change_max);
        self.position += self.velocity * dt_s;
        self.stop_at_limits();
    }

    /// The velocity from which the joint still comes to rest at `distance`: exponential at the end, and before that with
    /// half the acceleration, where the two curves and their slopes meet.
    fn approach(&self, distance: f64) -> f64 {
        let near = distance.abs() / CLOSING_S;
        let far = (self.acceleration_max * distance.abs()).sqrt();
        near.min(far).copysign(distance)
    }

    fn stop_at_limits(&mut self) {
        let clipped = self.limits.clip(self.position);
        if clipped != self.position {
            self.position = clipped;
            self.velocity = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        lower: -3.059,
        upper: 3.059,
        velocity: 4.0,
    };
    const ACCELERATION_MAX: f64 = 40.0;

    #[test]
    fn reaches_its_target_without_overshoot_within_velocity_and_acceleration() {
        let mut joint = Tracker::new(-1.0, LIMITS, ACCELERATION_MAX);
        let goal = Goal::Position {
            target: 1.0,
            speed: 0.3,
        };
        for _ in 0..3000 {
            let before = joint.velocity;
            joint.step(goal, 1e-3);
            assert!(joint.velocity.abs() <= 0.3 * LIMITS.velocity + 1e-12);
            assert!((joint.velocity - before).abs() <= ACCELERATION_MAX * 1e-3 + 1e-12);
            assert!(joint.position <= 1.0 + 1e-6);
        }
        assert!((joint.position - 1.0).abs() < 1e-6 && joint.velocity.abs() < 1e-6);
    }

    #[test]
    fn a_velocity_ends_at_the_joint_limit() {
        let mut joint = Tracker::new(2.5, LIMITS, ACCELERATION_MAX);
        for _ in 0..2000 {
            joint.step(Goal::Velocity(3.0), 1e-3);
        }
        assert!((joint.position - LIMITS.upper).abs() < 1e-4 && joint.velocity.abs() < 1e-4);
        joint.step(Goal::Velocity(-1.0), 1e-3);
        assert!(
            joint.velocity < 0.0,
            "the joint must be able to leave its limit"
        );
    }

    #[test]
    fn hold_brakes_and_stays() {
        let mut joint = Tracker::new(0.0, LIMITS, ACCELERATION_MAX);
        for _ in 0..500 {
            joint.step(Goal::Velocity(1.2), 1e-3);
        }
        let at = joint.position;
        for _ in 0..100 {
            joint.step(Goal::Hold, 1e-3);
        }
        assert_eq!(joint.velocity, 0.0);
        assert!(joint.position - at < 1.2 * 1.2 / (2.0 * ACCELERATION_MAX) + 1e-3);
    }
}
