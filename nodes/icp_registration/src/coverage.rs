//! How far round the object was seen.

use std::f64::consts::TAU;

use nalgebra::Point3;

/// Sectors of a turn: 5 degrees each.
const SECTORS: usize = 72;
/// A sector with fewer points than these in a view was not seen in it.
const POINTS_MIN: u32 = 10;

/// The sectors about the hand's z axis in which some view saw the outside of what the hand holds.
#[derive(Debug, Clone)]
pub(crate) struct Coverage([bool; SECTORS]);

impl Default for Coverage {
    fn default() -> Self {
        Self([false; SECTORS])
    }
}

impl Coverage {
    /// Adds a view: its points and the place of its camera, in the hand's frame, m.
    pub(crate) fn add(&mut self, points: &[Point3<f32>], camera: &Point3<f32>) {
        let mut counts = [0; SECTORS];
        for point in points {
            // The far wall of a cup, seen from within, faces the axis and not away from it.
            let is_outside = point.xy().coords.dot(&(camera - point).xy()) > 0.0;
            if is_outside {
                counts[sector(point)] += 1;
            }
        }
        for (seen, count) in self.0.iter_mut().zip(counts) {
            *seen |= count >= POINTS_MIN;
        }
    }

    /// The angle that was seen, rad.
    pub(crate) fn angle_rad(&self) -> f64 {
        let seen = self.0.iter().filter(|seen| **seen).count();
        TAU * seen as f64 / SECTORS as f64
    }
}

fn sector(point: &Point3<f32>) -> usize {
    let share = f64::from(point.y).atan2(f64::from(point.x)).rem_euclid(TAU) / TAU;
    ((share * SECTORS as f64) as usize).min(SECTORS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The side of a tube of 3 cm radius, seen from a camera in a direction.
    fn see(coverage: &mut Coverage, towards_rad: f64, inside: bool) {
        let camera = Point3::new(towards_rad.cos(), towards_rad.sin(), 0.3).cast::<f32>() * 0.4;
        let mut points = Vec::new();
        for step in 0..7200 {
            let angle = TAU * f64::from(step) / 7200.0;
            let faces = (angle - towards_rad).cos() > 0.03 / 0.4;
            if faces != inside {
                points.push(Point3::new(0.03 * angle.cos(), 0.03 * angle.sin(), 0.2).cast());
            }
        }
        coverage.add(&points, &camera);
    }

    #[test]
    fn each_view_adds_what_it_sees_first() {
        let mut coverage = Coverage::default();
        let mut seen = vec![coverage.angle_rad().to_degrees()];
        for towards_rad in [0.0, 0.6, 1.2, 3.2] {
            see(&mut coverage, towards_rad, false);
            seen.push(coverage.angle_rad().to_degrees());
        }
        let expected = [0.0, 171.0, 171.0 + 34.4, 171.0 + 68.8, 354.0];
        for (seen, expected) in seen.iter().zip(expected) {
            assert!(
                (seen - expected).abs() <= 11.0,
                "{seen:?}, not {expected:?}"
            );
        }
    }

    #[test]
    fn the_inside_of_the_far_wall_is_not_the_outside() {
        let mut coverage = Coverage::default();
        see(&mut coverage, 0.0, true);
        assert_eq!(coverage.angle_rad(), 0.0);
    }
}
