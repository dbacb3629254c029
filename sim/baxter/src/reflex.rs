//! A ReFlex hand as its driver shows it: angles in, angles and loads out.
//!
//! It has power of its own and does not know whether the robot is enabled.

/// Fingers, and the motor that turns two of them about their bases.
pub const REFLEX_MOTORS: usize = 4;
const PRESHAPE: usize = 3;

/// Largest angles that the driver takes, rad.
const ANGLES_MAX_RAD: [f64; REFLEX_MOTORS] = [3.6, 3.6, 3.6, 1.75];
/// The driver's default speeds, rad/s.
const SPEEDS_RAD_S: [f64; REFLEX_MOTORS] = [3.0, 3.0, 3.0, 2.0];
/// Load from which on the driver loosens, and to which.
const LOAD_MAX: f64 = 350.0;
const LOAD_LOOSENED: f64 = 300.0;
/// Load a radian by which a finger is told to go farther than it can. Assumed.
const LOAD_PER_RAD: f64 = 900.0;
/// Load of a finger that moves freely. Assumed.
const LOAD_FREE: f64 = 20.0;
/// Load with which an object is held that was put into the hand.
const LOAD_HOLDING: f64 = 180.0;
/// Distance between the fingertips when open, m; it shrinks evenly to nothing at [`CLOSED_RAD`]. Assumed.
const OPEN_WIDTH_M: f64 = 0.14;
const CLOSED_RAD: f64 = 2.1817;

/// One motor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ReflexMotor {
    /// Angle, rad.
    pub angle_rad: f64,
    /// Angular velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Load, in the driver's unit.
    pub load: f64,
    commanded_rad: f64,
}

/// The hand.
#[derive(Debug, Clone, Default)]
pub struct ReflexHand {
    motors: [ReflexMotor; REFLEX_MOTORS],
    object_width_m: Option<f64>,
}

impl ReflexHand {
    /// Fingers f1, f2, f3 and the preshape.
    pub fn motors(&self) -> &[ReflexMotor; REFLEX_MOTORS] {
        &self.motors
    }

    /// Distance between the fingertips, m.
    pub fn opening_m(&self) -> f64 {
        let mean_rad = self.motors[..PRESHAPE]
            .iter()
            .map(|motor| motor.angle_rad)
            .sum::<f64>()
            / 3.0;
        (OPEN_WIDTH_M * (1.0 - mean_rad / CLOSED_RAD)).max(0.0)
    }

    /// Takes a position command, rad; clipped to the limits, ignored where it is no number.
    pub fn command(&mut self, angles_rad: [f64; REFLEX_MOTORS]) {
        for ((motor, angle_rad), max_rad) in
            self.motors.iter_mut().zip(angles_rad).zip(ANGLES_MAX_RAD)
        {
            if angle_rad.is_finite() {
                motor.commanded_rad = angle_rad.clamp(0.0, max_rad);
            }
        }
    }

    /// See [`crate::Hand::hold`].
    pub(crate) fn hold(&mut self, object_width_m: Option<f64>) {
        if self.object_width_m == object_width_m {
            return;
        }
        self.object_width_m = object_width_m;
        if let Some(contact_rad) = self.contact_rad() {
            for motor in &mut self.motors[..PRESHAPE] {
                motor.angle_rad = contact_rad;
                motor.commanded_rad = contact_rad + LOAD_HOLDING / LOAD_PER_RAD;
            }
        }
    }

    pub(crate) fn step(&mut self, dt_s: f64) {
        let contact_rad = self.contact_rad();
        for (index, motor) in self.motors.iter_mut().enumerate() {
            let contact_rad = contact_rad
                .filter(|_| index != PRESHAPE)
                .unwrap_or(f64::INFINITY);
            motor.step(dt_s, SPEEDS_RAD_S[index], contact_rad);
        }
    }

    /// Angle at which the fingers touch the object.
    fn contact_rad(&self) -> Option<f64> {
        let width_m = self.object_width_m?;
        Some((CLOSED_RAD * (1.0 - width_m / OPEN_WIDTH_M)).max(0.0))
    }
}

impl ReflexMotor {
    fn step(&mut self, dt_s: f64, speed_rad_s: f64, contact_rad: f64) {
        let step_rad = speed_rad_s * dt_s;
        let wanted_rad =
            (self.commanded_rad - self.angle_rad).clamp(-step_rad, step_rad) + self.angle_rad;
        let before_rad = self.angle_rad;
        self.angle_rad = wanted_rad.min(contact_rad.max(before_rad));
        self.velocity_rad_s = (self.angle_rad - before_rad) / dt_s;
        let pressed_rad = self.commanded_rad - self.angle_rad;
        self.load = if self.angle_rad >= contact_rad && pressed_rad > 0.0 {
            LOAD_PER_RAD * pressed_rad
        } else if self.velocity_rad_s == 0.0 {
            0.0
        } else {
            LOAD_FREE
        };
        if self.load > LOAD_MAX {
            self.commanded_rad = self.angle_rad + LOAD_LOOSENED / LOAD_PER_RAD;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stepped(hand: &mut ReflexHand, seconds: f64) {
        (0..(seconds * 1000.0) as usize).for_each(|_| hand.step(1e-3));
    }

    #[test]
    fn fingers_go_where_they_are_told_within_limits_and_speed() {
        let mut hand = ReflexHand::default();
        hand.command([1.5, f64::NAN, 9.0, 0.5]);
        stepped(&mut hand, 0.25);
        assert!((hand.motors[0].angle_rad - 0.75).abs() < 0.01, "3 rad/s");
        stepped(&mut hand, 2.0);
        let angles_rad = hand.motors.map(|motor| motor.angle_rad);
        assert_eq!(angles_rad, [1.5, 0.0, 3.6, 0.5]);
        assert!(hand.motors.iter().all(|motor| motor.load == 0.0));
    }

    #[test]
    fn an_object_stops_them_and_loads_the_motors_until_the_driver_loosens() {
        let mut hand = ReflexHand {
            object_width_m: Some(0.07),
            ..Default::default()
        };
        hand.command([1.2, 1.2, 3.0, 0.0]);
        stepped(&mut hand, 2.0);
        let [gentle, _, hard, _] = hand.motors;
        assert!((hand.opening_m() - 0.07).abs() < 1e-6);
        let expected = LOAD_PER_RAD * (1.2 - CLOSED_RAD / 2.0);
        assert!((gentle.load - expected).abs() < 1e-6, "{}", gentle.load);
        assert!((hard.load - LOAD_LOOSENED).abs() < 1e-6, "{}", hard.load);
        hand.command([0.0; REFLEX_MOTORS]);
        stepped(&mut hand, 2.0);
        assert!((hand.opening_m() - OPEN_WIDTH_M).abs() < 1e-9);
    }
}
