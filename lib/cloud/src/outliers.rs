//! Outlier removal: by the number of neighbours within a radius, and statistical.

use std::num::NonZeroUsize;

use nalgebra::Point3;

use crate::Tree;
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

/// Which points' mean distance to their `neighbour_count` nearest others is at most the cloud's average of it plus
/// `deviations` of its standard deviations. Points must be finite.
pub fn statistical(
    points: &[Point3<f32>],
    neighbour_count: NonZeroUsize,
    deviations: f32,
) -> Vec<bool> {
    let Some(tree) = Tree::new(points) else {
        return Vec::new();
    };
    // One more, since the nearest neighbour of a point is the point itself.
    let wanted = neighbour_count.saturating_add(1);
    let mean_distance = |point| {
        let found = tree.nearest_n(point, wanted).skip(1);
        let (sum, count) = found.fold((0.0, 0), |(sum, count), near| {
            (sum + near.distance_sq.sqrt(), count + 1)
        });
        sum / count.max(1) as f32
    };
    let distances: Vec<f32> = points.iter().map(mean_distance).collect();
    let (mean, deviation) = mean_and_deviation(&distances);
    distances
        .iter()
        .map(|&distance| distance <= mean + deviations * deviation)
        .collect()
}

fn mean_and_deviation(values: &[f32]) -> (f32, f32) {
    let count = values.len() as f64;
    let mean = values.iter().map(|&value| f64::from(value)).sum::<f64>() / count;
    let variance = values
        .iter()
        .map(|&value| (f64::from(value) - mean).powi(2))
        .sum::<f64>()
        / count;
    (mean as f32, variance.sqrt() as f32)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
    fn a_stray_point_is_found_by_both_rules() {
        let mut points: Vec<_> = crate::random::points(2, 500, 1.0)
            .iter()
            .map(|point| point * 0.05)
            .collect();
        points.insert(123, Point3::new(0.3, 0.3, 0.3));
        let strays = |keep: Vec<bool>| {
            keep.iter()
                .enumerate()
                .filter(|(_, keep)| !**keep)
                .map(|(index, _)| index)
                .collect::<Vec<_>>()
        };
        assert_eq!(strays(radius(&points, 0.03, 3)), [123]);
        assert_eq!(
            strays(statistical(&points, NonZeroUsize::new(8).unwrap(), 6.0)),
            [123]
        );
    }

    #[test]
    fn no_points_have_no_strays() {
        assert!(radius(&[], 0.1, 3).is_empty());
        assert!(statistical(&[], NonZeroUsize::MIN, 1.0).is_empty());
        assert_eq!(
            statistical(&[Point3::origin()], NonZeroUsize::MIN, 1.0),
            [true]
        );
        assert_eq!(radius(&[Point3::origin()], 0.1, 1), [false]);
    }
}
