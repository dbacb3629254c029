#![allow(clippy::unwrap_used)]
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

fn random_points(random: &mut Pcg64Mcg, count: usize) -> Vec<Point3<f32>> {
    (0..count)
        .map(|_| Point3::new(random.random(), random.random(), random.random()))
        .collect()
}

fn distances_sq(points: &[Point3<f32>], query: &Point3<f32>) -> Vec<f32> {
    points
        .iter()
        .map(|point| (point - query).norm_squared())
        .collect()
}

#[test]
fn agrees_with_looking_at_every_point() {
    let seed = 7;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for count in [1, 2, 31, 33, 1000] {
        let points = random_points(&mut random, count);
        let tree = Tree::new(&points).unwrap();
        for query in random_points(&mut random, 50) {
            let by_index = distances_sq(&points, &query);
            let mut sorted = by_index.clone();
            sorted.sort_by(f32::total_cmp);

            let nearest = tree.nearest(&query);
            assert!((nearest.distance_sq - sorted[0]).abs() < 1e-6);
            assert!((by_index[nearest.index] - sorted[0]).abs() < 1e-6);

            let wanted = NonZeroUsize::new(5).unwrap();
            let nearest: Vec<_> = tree
                .nearest_n(&query, wanted)
                .map(|found| found.distance_sq)
                .collect();
            assert_eq!(nearest.len(), count.min(5));
            assert!(
                nearest
                    .iter()
                    .zip(&sorted)
                    .all(|(found, expected)| (found - expected).abs() < 1e-6)
            );

            let expected = sorted
                .iter()
                .filter(|&&distance_sq| distance_sq < 0.09)
                .count();
            assert_eq!(tree.within(&query, 0.3).count(), expected);
        }
    }
}

#[test]
fn many_copies_of_a_point_are_all_found() {
    let points = vec![Point3::new(0.1, 0.2, 0.3); 500];
    let tree = Tree::new(&points).unwrap();
    assert_eq!(tree.within(&points[0], 0.01).count(), 500);
    assert!((tree.nearest(&Point3::origin()).distance_sq - 0.14).abs() < 1e-6);
}

#[test]
fn no_points_make_no_tree() {
    assert!(Tree::new(&[]).is_none());
}
