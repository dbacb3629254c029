#![allow(clippy::unwrap_used)]
use std::collections::BTreeMap;

use super::*;

fn by_cube(points: &[Point3<f32>], size_m: f32) -> BTreeMap<[i32; 3], Vec<Point3<f32>>> {
    let mut cubes = BTreeMap::<_, Vec<_>>::new();
    for point in points {
        let cube = point
            .coords
            .map(|coordinate| (coordinate / size_m).floor() as i32);
        cubes.entry(cube.into()).or_default().push(*point);
    }
    cubes
}

fn downsample_slow(points: &[Point3<f32>], size_m: f32) -> Vec<Point3<f32>> {
    by_cube(points, size_m)
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

fn without_noise_slow(points: &[Point3<f32>], size_m: f32, shares: [f32; 2]) -> Vec<Point3<f32>> {
    let cubes = by_cube(points, size_m);
    let around = |cube: &[i32; 3]| -> Vec<usize> {
        let neighbours = (0..3).flat_map(|axis| [-1, 1].map(|step| (axis, step)));
        let count = |(axis, step): (usize, i32)| {
            let mut neighbour = *cube;
            neighbour[axis] += step;
            cubes.get(&neighbour).map_or(0, Vec::len)
        };
        neighbours.map(count).collect()
    };
    let sum = |cube: &[i32; 3]| cubes[cube].len() + around(cube).iter().sum::<usize>();
    let mut sums: Vec<usize> = cubes.keys().map(sum).collect();
    sums.sort_unstable();
    let is_surface = |cube: &[i32; 3]| {
        let most = *around(cube).iter().max().unwrap();
        cubes[cube].len() as f32 >= shares[0] * most as f32
            && sum(cube) as f32 >= shares[1] * sums[sums.len() / 2] as f32
    };
    let kept = cubes.iter().filter(|(cube, _)| is_surface(cube));
    kept.map(|(_, points)| crate::centroid(points).unwrap())
        .collect()
}

#[test]
fn noise_agrees_with_an_ordered_map() {
    for (seed, count) in [(11, 50), (12, 800), (13, 6000)] {
        // Denser towards the middle.
        let points: Vec<_> = crate::random::points(seed, count, 0.2)
            .iter()
            .map(|point| point * point.coords.norm())
            .collect();
        let mut grid = Grid::new(0.004).unwrap();
        // Neighbours of cubes that were there before are found, too.
        let mut added = 0;
        for part in points.chunks(count.div_ceil(3)) {
            grid.extend(part).unwrap();
            added += part.len();
            for shares in [[0.0, 0.0], [0.3, 0.2], [0.9, 0.9], [2.0, 0.0]] {
                let fast = grid.means_without_noise(shares[0], shares[1]);
                let slow = without_noise_slow(&points[..added], 0.004, shares);
                assert_eq!(sorted(fast), sorted(slow), "{added} points, {shares:?}");
            }
        }
    }
    let mut empty = Grid::new(0.004).unwrap();
    assert!(empty.means_without_noise(0.3, 0.2).is_empty());
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
