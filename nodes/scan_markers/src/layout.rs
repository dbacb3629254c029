//! Positions of a scan's clouds in the picture.

use nalgebra::{Isometry3, Point3, Translation3, Unit, Vector3};

/// Step of the hue from view to view, as a share of the colour circle: by the golden ratio each hue is far from all before.
const HUE_STEP: f32 = 0.618_034;

/// Where a scan is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Frame in which it is drawn.
    pub frame: String,
    /// Maps the common frame of the scan's views into it.
    pub frame_from_scan: Isometry3<f64>,
    /// Upward direction in that frame.
    pub up: Unit<Vector3<f64>>,
    /// Direction to the left, as seen from behind the robot, in that frame.
    pub left: Unit<Vector3<f64>>,
}

impl Layout {
    /// Layout in a frame whose z axis points up; `frame_from_hand` is the hand's pose when the scan began.
    pub fn level(frame: &str, frame_from_hand: Isometry3<f64>) -> Self {
        Self {
            frame: frame.into(),
            frame_from_scan: frame_from_hand,
            up: Vector3::z_axis(),
            left: Vector3::y_axis(),
        }
    }

    /// Layout in the optical frame of a camera (z forward, y down), for scans without a known hand.
    pub fn optical(frame: &str) -> Self {
        Self {
            frame: frame.into(),
            frame_from_scan: Isometry3::identity(),
            up: -Vector3::y_axis(),
            left: -Vector3::x_axis(),
        }
    }

    /// Maps points of the scan to their position in the picture, shifted to the left by `left_m`.
    pub fn beside(&self, left_m: f64) -> Isometry3<f64> {
        Translation3::from(self.left.scale(left_m)) * self.frame_from_scan
    }

    /// A position `distance_m` above the highest of these points, which are in the layout's frame.
    pub fn above(&self, points: &[Point3<f64>], distance_m: f64) -> Option<Point3<f64>> {
        let count = points.len() as f64;
        let sum = points
            .iter()
            .map(|point| point.coords)
            .sum::<Vector3<f64>>();
        let middle = sum / count;
        let height = |point: &Point3<f64>| point.coords.dot(&self.up);
        let top_m = points.iter().map(height).reduce(f64::max)?;
        let rise_m = top_m - middle.dot(&self.up) + distance_m;
        Some(Point3::from(middle + self.up.scale(rise_m)))
    }
}

/// Red, green and blue of a view, 0 to 1.
pub fn view_colour(index: u32) -> [f32; 3] {
    // Begins at blue, because green and red mark kept and removed points.
    let hue = 6.0 * (0.58 + index as f32 * HUE_STEP).fract();
    let channel = |shift: f32| {
        let distance = ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
        0.25 + 0.75 * distance.clamp(0.0, 1.0)
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn neighbouring_views_differ_in_colour() {
        let colours: Vec<_> = (0..8).map(view_colour).collect();
        for (index, colour) in colours.iter().enumerate() {
            assert!(colour.iter().all(|channel| (0.0..=1.0).contains(channel)));
            for other in &colours[..index] {
                let distance: f32 = colour.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
                assert!(distance > 0.15, "{colour:?} {other:?}");
            }
        }
    }

    #[test]
    fn clouds_stand_beside_the_hand_and_words_above_them() {
        let hand = Isometry3::new(Vector3::new(0.6, 0.1, 0.4), Vector3::z() * 0.3);
        let layout = Layout::level("base", hand);
        let drawn = layout.beside(0.3) * Point3::new(0.0, 0.0, 0.2);
        assert!((drawn - Point3::new(0.6, 0.4, 0.6)).norm() < 1e-12);
        let points = [Point3::new(0.0, 0.0, 1.0), Point3::new(2.0, 0.0, 3.0)];
        assert_eq!(
            layout.above(&points, 0.5).unwrap(),
            Point3::new(1.0, 0.0, 3.5)
        );
        let optical = Layout::optical("camera");
        assert_eq!(
            optical.above(&points[..1], 0.5).unwrap(),
            Point3::new(0.0, -0.5, 1.0)
        );
        assert_eq!(layout.above(&[], 0.5), None);
    }
}
