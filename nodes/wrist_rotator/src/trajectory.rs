//! From one angle to another with bounded velocity, acceleration and jerk.

/// A motion of one joint from rest to rest: trapezoidal velocity, averaged over a short window so that the acceleration
/// rises and falls gradually.
///
/// The average of a trapezoid keeps its velocity and acceleration limits, adds the window to its duration, and its jerk is
/// the acceleration divided by the window.
#[derive(Debug, Clone)]
pub struct Trajectory {
    start_rad: f64,
    target_rad: f64,
    jerk_time_s: f64,
    acceleration_rad_s2: f64,
    /// Time spent accelerating, and again slowing down.
    ramp_s: f64,
    cruise_s: f64,
}

impl Trajectory {
    /// From `start_rad` to `target_rad`; limits must be positive, `jerk_time_s` may be 0.
    pub fn new(
        start_rad: f64,
        target_rad: f64,
        velocity_max_rad_s: f64,
        acceleration_max_rad_s2: f64,
        jerk_time_s: f64,
    ) -> Self {
        let distance_rad = (target_rad - start_rad).abs();
        let full_ramp_s = velocity_max_rad_s / acceleration_max_rad_s2;
        // A short way ends before the full velocity is reached.
        let ramp_s = full_ramp_s.min((distance_rad / acceleration_max_rad_s2).sqrt());
        let ramps_rad = acceleration_max_rad_s2 * ramp_s * ramp_s;
        let cruise_s = ((distance_rad - ramps_rad) / velocity_max_rad_s).max(0.0);
        let acceleration_rad_s2 = acceleration_max_rad_s2;
        Self {
            start_rad,
            target_rad,
            jerk_time_s,
            acceleration_rad_s2,
            ramp_s,
            cruise_s,
        }
    }

    /// From the first movement to rest.
    pub fn duration_s(&self) -> f64 {
        self.trapezoid_s() + self.jerk_time_s
    }

    /// The angle `time_s` after the start; the start before it, the target after the end.
    pub fn angle_rad(&self, time_s: f64) -> f64 {
        if time_s <= 0.0 {
            return self.start_rad;
        }
        if time_s >= self.duration_s() {
            return self.target_rad;
        }
        let travelled_rad = if self.jerk_time_s > 0.0 {
            let window = self.area(time_s) - self.area(time_s - self.jerk_time_s);
            window / self.jerk_time_s
        } else {
            self.travelled(time_s)
        };
        self.start_rad + travelled_rad.copysign(self.target_rad - self.start_rad)
    }

    fn trapezoid_s(&self) -> f64 {
        2.0 * self.ramp_s + self.cruise_s
    }

    fn distance_rad(&self) -> f64 {
        (self.target_rad - self.start_rad).abs()
    }

    /// Way of the trapezoid alone.
    fn travelled(&self, time_s: f64) -> f64 {
        let left_s = self.trapezoid_s() - time_s;
        let half_acceleration = self.acceleration_rad_s2 / 2.0;
        if time_s <= 0.0 {
            0.0
        } else if left_s <= 0.0 {
            self.distance_rad()
        } else if time_s < self.ramp_s {
            half_acceleration * time_s * time_s
        } else if left_s < self.ramp_s {
            self.distance_rad() - half_acceleration * left_s * left_s
        } else {
            self.acceleration_rad_s2 * self.ramp_s * (time_s - self.ramp_s / 2.0)
        }
    }

    /// Integral of the trapezoid's way from 0 to `time_s`.
    fn area(&self, time_s: f64) -> f64 {
        let total_s = self.trapezoid_s();
        let left_s = total_s - time_s;
        let distance_rad = self.distance_rad();
        // The way is point-symmetric about the middle of the motion, hence the area under all of it.
        let total = distance_rad * total_s / 2.0;
        let cubic = |ramp_s: f64| self.acceleration_rad_s2 * ramp_s.powi(3) / 6.0;
        if time_s <= 0.0 {
            0.0
        } else if left_s <= 0.0 {
            total - distance_rad * left_s
        } else if time_s < self.ramp_s {
            cubic(time_s)
        } else if left_s < self.ramp_s {
            total - distance_rad * left_s + cubic(left_s)
        } else {
            let cruised_s = time_s - self.ramp_s;
            let velocity_rad_s = self.acceleration_rad_s2 * self.ramp_s;
            let at_ramp_end_rad = velocity_rad_s * self.ramp_s / 2.0;
            let cruise = at_ramp_end_rad * cruised_s + velocity_rad_s * cruised_s * cruised_s / 2.0;
            cubic(self.ramp_s) + cruise
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VELOCITY_MAX: f64 = 1.0;
    const ACCELERATION_MAX: f64 = 5.0;
    const JERK_TIME_S: f64 = 0.06;
    const TICK_S: f64 = 1e-3;

    fn check_laws(start_rad: f64, target_rad: f64) {
        let path = Trajectory::new(
            start_rad,
            target_rad,
            VELOCITY_MAX,
            ACCELERATION_MAX,
            JERK_TIME_S,
        );
        let ticks = (path.duration_s() / TICK_S) as i64 + 20;
        let angles: Vec<f64> = (-20..ticks)
            .map(|tick| path.angle_rad(tick as f64 * TICK_S))
            .collect();
        assert_eq!(angles[0], start_rad);
        assert_eq!(angles[angles.len() - 1], target_rad);
        let rates = |values: &[f64]| -> Vec<f64> {
            values
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) / TICK_S)
                .collect()
        };
        let velocities = rates(&angles);
        let accelerations = rates(&velocities);
        let jerks = rates(&accelerations);
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |max, v| max.max(v.abs()));
        let jerk_max = ACCELERATION_MAX / JERK_TIME_S;
        assert!(largest(&velocities) <= VELOCITY_MAX + 1e-6);
        assert!(largest(&accelerations) <= ACCELERATION_MAX + 1e-3);
        assert!(
            largest(&jerks) <= 2.0 * jerk_max + 1.0,
            "{}",
            largest(&jerks)
        );
        let forward = (target_rad - start_rad).signum();
        assert!(
            velocities.iter().all(|v| v * forward >= -1e-9),
            "never turns back"
        );
    }

    #[test]
    fn limits_hold_on_long_short_and_backward_ways() {
        for (start_rad, target_rad) in [
            (0.0, 0.6),
            (0.6, -0.6),
            (-3.0, 3.0),
            (1.0, 1.01),
            (0.0, 0.2),
            (0.5, 0.5 + 1e-6),
        ] {
            check_laws(start_rad, target_rad);
        }
    }

    #[test]
    fn a_step_of_0_6_rad_takes_0_86_s() {
        let path = Trajectory::new(0.0, 0.6, VELOCITY_MAX, ACCELERATION_MAX, JERK_TIME_S);
        assert!((path.duration_s() - 0.86).abs() < 1e-9);
        assert!(
            (path.angle_rad(0.43) - 0.3).abs() < 1e-9,
            "symmetric about the middle"
        );
    }

    #[test]
    fn without_jerk_limit_it_is_the_trapezoid() {
        let path = Trajectory::new(0.0, 0.6, VELOCITY_MAX, ACCELERATION_MAX, 0.0);
        assert!((path.duration_s() - 0.8).abs() < 1e-9);
        assert!((path.angle_rad(0.2) - 0.1).abs() < 1e-9);
        assert!((path.angle_rad(0.5) - 0.4).abs() < 1e-9);
    }

    #[test]
    fn no_way_at_all_stays() {
        let path = Trajectory::new(0.4, 0.4, VELOCITY_MAX, ACCELERATION_MAX, JERK_TIME_S);
        assert!((path.angle_rad(0.03) - 0.4).abs() < 1e-15);
        assert_eq!(path.angle_rad(1.0), 0.4);
    }
}
