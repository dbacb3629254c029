//! Outlier removal by the number of neighbours within a radius.

use nalgebra::Point3;

use crate::cells::Cells;

/// Which points have at least `min_neighbours` other points nearer than `radius_m`. Points must be finite.
///
/// Stops counting at the limit, so that a dense cloud costs little.
pub fn radius(points: &[Point3<f32>], radius_m: f32, min_neighbours: usize) -> Vec<bool> {
    let cells = Cells::new(points, radius_m);
    let radius_sq = radius_m * radius_m;
    let has_enough = |(index, point): (usize, &Point3<f32>)| {
        let mut found = 0;
        for other in cells.around(point) {
            found +=
                usize::from(other != index && (points[other] - point).norm_squared() < radius_sq);
            if found >= min_neighbours {
                return true;
            }
        }
        min_neighbours == 0
    };
    points.iter().enumerate().map(has_enough).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radius_agrees_with_looking_at_every_pair() {
        let points = crate::random::points(1, 800, 1.0);
        for (radius_m, min_neighbours) in [(0.05, 1), (0.1, 4), (0.4, 60), (3.0, 799), (3.0, 800)] {
            let slow: Vec<bool> = points
                .iter()
                .map(|point| {
                    points
                        .iter()
                        .filter(|other| (*other - point).norm() < radius_m)
                        .count()
                        > min_neighbours
                })
                .collect();
            assert_eq!(
                radius(&points, radius_m, min_neighbours),
                slow,
                "{radius_m} m, {min_neighbours}"
            );
        }
    }

    #[test]
    fn a_stray_point_is_found() {
        let mut points: Vec<_> = crate::random::points(2, 500, 1.0)
            .iter()
            .map(|point| point * 0.05)
            .collect();
        points.insert(123, Point3::new(0.3, 0.3, 0.3));
        let keep = radius(&points, 0.03, 3);
        let strays: Vec<_> = (0..points.len()).filter(|&index| !keep[index]).collect();
        assert_eq!(strays, [123]);
    }

    #[test]
    fn no_points_have_no_strays() {
        assert!(radius(&[], 0.1, 3).is_empty());
        assert_eq!(radius(&[Point3::origin()], 0.1, 1), [false]);
    }
}
