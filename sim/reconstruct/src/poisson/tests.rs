#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use mesh::Mesh;
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::lattice::{Lattice, children, corners, dilated, key, place};
use super::level::Level;
use super::solve::{Pin, solve};
use super::*;

fn random_places(seed: u64, count: usize) -> BTreeSet<[i32; 3]> {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..count)
        .map(|_| [(); 3].map(|()| random.random_range(0..12)))
        .collect()
}

/// All sums of a place of the set and a step.
fn sums(
    set: &BTreeSet<[i32; 3]>,
    factor: i32,
    steps: std::ops::RangeInclusive<i32>,
) -> Vec<[i32; 3]> {
    let mut all = BTreeSet::new();
    for [x, y, z] in set {
        for dx in steps.clone() {
            for dy in steps.clone() {
                all.extend(
                    steps
                        .clone()
                        .map(|dz| [factor * x + dx, factor * y + dy, factor * z + dz]),
                );
            }
        }
    }
    all.into_iter().collect()
}

#[test]
fn sets_of_places_agree_with_looking_at_every_place() {
    for seed in 0..5 {
        let set = random_places(seed, 60);
        let keys: Vec<u64> = set.iter().map(|&at| key(at)).collect();
        let places = |keys: Vec<u64>| keys.into_iter().map(place).collect::<Vec<_>>();
        assert_eq!(places(dilated(&keys)), sums(&set, 1, -1..=1));
        assert_eq!(places(corners(&keys)), sums(&set, 1, 0..=1));
        assert_eq!(places(children(&keys)), sums(&set, 2, 0..=1));
        let lattice = Lattice::new(keys.clone());
        for at in sums(&set, 1, -2..=2) {
            let expected = keys.iter().position(|&other| other == key(at));
            assert_eq!(lattice.find(key(at)).map(|index| index as usize), expected);
        }
    }
    assert_eq!(Lattice::new(Vec::new()).find(key([0; 3])), None);
}

fn full_level(depth: u32) -> Level {
    Level::new(depth, cascade::all_cells(depth), 0.0)
}

/// Sets f at every place of a level.
fn set(level: &mut Level, f: impl Fn(Vector3<f64>) -> f64) {
    let cell = level.cell();
    let at = |&key: &u64| f(Vector3::from(place(key).map(f64::from)) * cell);
    level.values = level.lattice.keys().iter().map(at).collect();
}

#[test]
fn a_field_that_is_a_gradient_is_integrated_exactly() {
    let f = |at: Vector3<f64>| at.x * at.x - 0.5 * at.y + at.z * at.z * 3.0;
    let mut level = full_level(4);
    set(&mut level, f);
    let expected = level.values.clone();
    let field: Vec<Vector3<f64>> = level
        .lattice
        .keys()
        .iter()
        .map(|&key| Vector3::from(place(key).map(f64::from)) * level.cell())
        .map(|at| Vector3::new(2.0 * at.x, -0.5, 6.0 * at.z))
        .collect();
    for &free in &level.free {
        level.values[free as usize] = 0.0;
    }
    solve(&mut level, &field, &[], 1e-12, 1000);
    for (value, expected) in level.values.iter().zip(&expected) {
        assert!((value - expected).abs() < 1e-8, "{value} for {expected}");
    }
}

#[test]
fn a_heavy_pin_holds_f_at_zero() {
    let mut level = full_level(3);
    set(&mut level, |_| 0.5);
    let point = Point3::new(0.41, 0.52, 0.63);
    let corners = level.corners(&point).unwrap();
    let field = vec![Vector3::zeros(); level.values.len()];
    solve(
        &mut level,
        &field,
        &[Pin {
            corners,
            weight: 1e6,
        }],
        1e-10,
        1000,
    );
    assert!(corners.of(&level.values).abs() < 1e-5);
}

#[test]
fn values_and_gradients_of_a_trilinear_function_are_exact() {
    let mut level = full_level(3);
    set(&mut level, |at| 1.0 + 2.0 * at.x - at.y * at.z);
    let at = Point3::new(0.3, 0.45, 0.7);
    let (value, gradient) = level.value_and_gradient(&at).unwrap();
    assert!((value - (1.0 + 2.0 * at.x - at.y * at.z)).abs() < 1e-12);
    assert!((gradient - Vector3::new(2.0, -at.z, -at.y)).norm() < 1e-12);
    let mut fine = full_level(4);
    let interpolated = fine.interpolated(&level, &level.values);
    set(&mut fine, |at| 1.0 + 2.0 * at.x - at.y * at.z);
    for (found, value) in interpolated.into_iter().zip(&fine.values) {
        assert!((found.unwrap() - value).abs() < 1e-12);
    }
}

#[test]
fn contours_of_random_values_are_closed_and_have_their_inside_within() {
    for seed in 0..20 {
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut level = full_level(3);
        set(&mut level, |_| 0.5);
        let mut inside = 0;
        for &free in &level.free {
            let value: f64 = random.random_range(-1.0..1.0);
            level.values[free as usize] = value;
            inside += usize::from(value < 0.0);
        }
        let surface = contour::contour(&level, 0.0);
        let directed: Vec<(u32, u32)> = surface
            .triangles
            .iter()
            .flat_map(|&corners| mesh::sides(corners))
            .collect();
        let unique: BTreeSet<(u32, u32)> = directed.iter().copied().collect();
        assert!(
            unique
                .iter()
                .all(|&(from, to)| unique.contains(&(to, from))),
            "a hole"
        );
        assert_eq!(
            unique.len(),
            directed.len(),
            "an edge with more than two triangles"
        );
        let mesh = Mesh {
            vertices: surface.points.iter().map(|point| point.cast()).collect(),
            triangles: surface.triangles,
        };
        let cells = mesh.volume_m3() / level.cell().powi(3);
        assert!(
            (0.5..1.0).contains(&(cells / inside as f64)),
            "{cells} cells for {inside} places"
        );
    }
}
