#![allow(clippy::unwrap_used)]
use super::*;

/// The definition, written as plainly as possible.
fn farthest_points_slow(points: &[Point3<f32>], count: usize) -> Vec<usize> {
    let first_largest = |score: &dyn Fn(usize) -> f32| {
        (1..points.len()).fold(0, |best, index| {
            if score(index) > score(best) {
                index
            } else {
                best
            }
        })
    };
    let centre = centroid(points).unwrap();
    let mut chosen = vec![first_largest(&|index| {
        (points[index] - centre).norm_squared()
    })];
    while chosen.len() < count {
        let next = first_largest(&|index| {
            let nearest = chosen
                .iter()
                .map(|&other| (points[index] - points[other]).norm_squared());
            if chosen.contains(&index) {
                -1.0
            } else {
                nearest.fold(f32::INFINITY, f32::min)
            }
        });
        chosen.push(next);
    }
    chosen
}

#[test]
fn agrees_with_the_definition() {
    for (seed, count) in [(1, 5), (2, 8), (3, 61), (4, 300)] {
        let points = crate::random::points(seed, count, 1.0);
        let wanted = count.min(40);
        assert_eq!(
            farthest_points(&points, wanted).unwrap(),
            farthest_points_slow(&points, wanted)
        );
    }
}

#[test]
fn all_points_of_a_cloud_come_once_each_even_with_copies() {
    let mut points = crate::random::points(5, 10, 1.0);
    points.extend_from_within(..);
    let mut indices = farthest_points(&points, 20).unwrap();
    indices.sort_unstable();
    assert_eq!(indices, (0..20).collect::<Vec<_>>());
}

#[test]
fn too_few_and_not_finite_points_are_refused_and_none_is_none() {
    let mut points = crate::random::points(6, 3, 1.0);
    assert_eq!(
        farthest_points(&points, 4),
        Err(SampleError::TooFew {
            count: 4,
            available: 3
        })
    );
    assert_eq!(farthest_points(&[], 0), Ok(Vec::new()));
    points[1].y = f32::NAN;
    assert_eq!(
        farthest_points(&points, 2),
        Err(SampleError::NotFinite { index: 1 })
    );
}
