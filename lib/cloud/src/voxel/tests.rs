#![allow(clippy::unwrap_used)]
use std::collections::BTreeMap;

use super::*;

fn downsample_slow(points: &[Point3<f32>], size_m: f32) -> Vec<Point3<f32>> {
    let mut cubes: BTreeMap<[i32; 3], Vec<Point3<f32>>> = BTreeMap::new();
    for point in points {
        let cube = point
            .coords
            .map(|coordinate| (coordinate / size_m).floor() as i32);
        cubes.entry(cube.into()).or_default().push(*point);
    }
    cubes
        .values()
        .map(|points| crate::centroid(points).unwrap())
        .collect()
}

fn sorted(mut points: Vec<Point3<f32>>) -> Vec<Point3<f32>> {
    points.sort_by(|a, b| {
        a.coords
            .as_slice()
            .partial_cmp(b.coords.as_slice())
            .unwrap()
    });
    points
}

#[test]
fn agrees_with_an_ordered_map() {
    for (seed, size_m) in [(1, 0.002), (2, 0.01), (3, 0.03), (4, 1.0)] {
        let points = crate::random::points(seed, 3000, 0.1);
        let fast = downsample(&points, size_m).unwrap();
        assert_eq!(
            sorted(fast),
            sorted(downsample_slow(&points, size_m)),
            "voxels of {size_m} m"
        );
    }
}

#[test]
fn adding_view_by_view_equals_adding_at_once() {
    let points = crate::random::points(5, 2000, 0.1);
    let mut grid = Grid::new(0.004).unwrap();
    points
        .chunks(137)
        .for_each(|part| grid.extend(part).unwrap());
    assert_eq!(
        grid.means().collect::<Vec<_>>(),
        downsample(&points, 0.004).unwrap()
    );
    assert_eq!(grid.len(), grid.means().len());
    assert!(
        grid.means()
            .enumerate()
            .all(|(index, mean)| grid.cell_of(&mean) == Some(index))
    );
    assert_eq!(grid.cell_of(&Point3::new(1.0, 1.0, 1.0)), None);
}

#[test]
fn points_on_both_sides_of_the_origin_do_not_share_a_cube() {
    let points = [Point3::new(0.001, 0.0, 0.0), Point3::new(-0.001, 0.0, 0.0)];
    assert_eq!(downsample(&points, 0.01).unwrap(), points);
}

#[test]
fn bad_sizes_and_points_are_refused() {
    for size_m in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(Grid::new(size_m), Err(VoxelError::Size(_))));
    }
    for bad in [f32::NAN, f32::INFINITY, 1e7] {
        let points = [Point3::origin(), Point3::new(0.0, bad, 0.0)];
        assert!(matches!(
            downsample(&points, 0.002),
            Err(VoxelError::OutOfRange { index: 1, .. })
        ));
    }
    assert_eq!(downsample(&[], 0.002), Ok(Vec::new()));
    let mut grid = Grid::new(0.002).unwrap();
    assert!(
        grid.extend(&[Point3::origin(), Point3::new(0.0, f32::NAN, 0.0)])
            .is_err()
    );
    assert!(grid.is_empty());
}
