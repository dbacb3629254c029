#![allow(clippy::unwrap_used)]
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

/// Compares with looking at every point, from places in and around the cloud.
fn check(points: &[Point3<f32>], side_m: f32, random: &mut Pcg64Mcg) {
    let rows = Rows::new(points, side_m).unwrap();
    for _ in 0..50 {
        let start = points[random.random_range(0..points.len())];
        let radius_m = random.random_range(0.0..4.0) * side_m;
        let place = start + Vector3::from_fn(|_, _| random.random_range(-4.0..4.0) * side_m);
        let distance_sq = |index: usize| (place - points[index]).norm_squared();
        let expected: Vec<usize> = (0..points.len())
            .filter(|&index| distance_sq(index) <= radius_m * radius_m)
            .collect();
        let mut found = Vec::new();
        rows.within(&place, radius_m, |index, distance| {
            assert_eq!(distance, distance_sq(index as usize));
            found.push(index as usize);
        });
        found.sort_unstable();
        assert_eq!(found, expected, "within {radius_m} m of {place}");
    }
}

#[test]
fn agree_with_looking_at_every_point() {
    let seed = 3;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    // Extents along x, y and z, m: a volume, planes, lines and one place.
    for extents in [
        [1, 1, 1],
        [0, 1, 1],
        [1, 0, 1],
        [1, 1, 0],
        [1, 0, 0],
        [0, 0, 1],
        [0, 0, 0],
    ] {
        let extents = Vector3::from(extents).cast::<f32>() * 0.1;
        let mut points: Vec<_> = (0..400)
            .map(|_| {
                extents
                    .map(|extent| random.random_range(-1.0..1.0) * extent)
                    .into()
            })
            .collect();
        points.extend_from_within(..20);
        for side_m in [0.0005, 0.008, 1.0] {
            check(&points, side_m, &mut random);
        }
    }
}

#[test]
fn a_point_far_away_does_not_make_millions_of_rows() {
    let points = [Point3::origin(), Point3::new(0.0, 900.0, -900.0)];
    let rows = Rows::new(&points, 0.002).unwrap();
    assert!(rows.starts.len() < 100, "{} rows", rows.starts.len());
    check(&points, 0.002, &mut Pcg64Mcg::seed_from_u64(0));
}

#[test]
fn no_points_make_no_rows() {
    assert!(Rows::new(&[], 0.002).is_none());
}
