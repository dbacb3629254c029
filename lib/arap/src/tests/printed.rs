//! The printed energy against dense matrices made another way.

use std::collections::BTreeMap;

use mesh::Mesh;
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

use super::{apart_m, pinch, rims, tube};
use crate::{Arap, ArapSettings, Laplacian};

/// Eq. 2 as a dense matrix, 1/mm², edge by edge.
fn dense(mesh: &Mesh) -> DMatrix<f64> {
    let places: Vec<Vector3<f64>> = mesh
        .vertices
        .iter()
        .map(|place| place.coords.cast() * 1e3)
        .collect();
    let count = places.len();
    let (mut matrix, mut areas) = (DMatrix::zeros(count, count), vec![0.0; count]);
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| vertex as usize);
        let angles = [0, 1, 2].map(|k| {
            let [a, b, c] = [0, 1, 2].map(|step| places[corners[(k + step) % 3]]);
            (b - a).angle(&(c - a))
        });
        let [a, b, c] = corners.map(|vertex| places[vertex]);
        let area = (b - a).cross(&(c - a)).norm() / 2.0;
        let is_obtuse = angles
            .iter()
            .any(|&angle| angle > std::f64::consts::FRAC_PI_2);
        for k in 0..3 {
            let [own, next, last] = [0, 1, 2].map(|step| (k + step) % 3);
            let weight = 0.5 / angles[own].tan();
            for (one, other) in [(next, last), (last, next)] {
                matrix[(corners[one], corners[one])] += weight;
                matrix[(corners[one], corners[other])] -= weight;
            }
            areas[corners[own]] += if !is_obtuse {
                let half = |to: usize, opposite: usize| {
                    let side = places[corners[own]] - places[corners[to]];
                    side.norm_squared() / angles[opposite].tan() / 8.0
                };
                half(next, last) + half(last, next)
            } else if angles[own] > std::f64::consts::FRAC_PI_2 {
                area / 2.0
            } else {
                area / 4.0
            };
        }
    }
    for (row, area) in areas.into_iter().enumerate() {
        matrix.row_mut(row).scale_mut(1.0 / area);
    }
    matrix
}

/// The least energy that turns of rotations and places come to, mm², and the places.
fn slowly(
    mesh: &Mesh,
    ties: &BTreeMap<usize, Vector3<f64>>,
    smoothing_mm2: f64,
    turns: usize,
) -> (f64, Vec<Point3<f64>>) {
    let operator = dense(mesh);
    let count = mesh.vertices.len();
    let rest = DMatrix::from_fn(count, 3, |row, axis| {
        1e3 * f64::from(mesh.vertices[row][axis])
    });
    let deltas = &operator * &rest;
    let vector =
        |matrix: &DMatrix<f64>, row: usize| Vector3::from_fn(|axis, _| matrix[(row, axis)]);
    let mut system = operator.transpose() * &operator;
    ties.keys()
        .for_each(|&vertex| system[(vertex, vertex)] += 1.0);
    let system = system.cholesky().unwrap();
    let is_edge = |a: usize, b: usize| a != b && operator[(a, b)] != 0.0;
    let mut rotations = vec![Matrix3::<f64>::identity(); count];
    let (mut energy, mut places) = (0.0, rest.clone());
    for _ in 0..turns {
        let mut wanted = DMatrix::zeros(count, 3);
        for row in 0..count {
            let turned = rotations[row] * vector(&deltas, row);
            (0..3).for_each(|axis| wanted[(row, axis)] = turned[axis]);
        }
        let mut right = operator.transpose() * &wanted;
        for (&vertex, place) in ties {
            (0..3).for_each(|axis| right[(vertex, axis)] += place[axis]);
        }
        places = system.solve(&right);
        let found = &operator * &places;
        for own in 0..count {
            let mut pull = vector(&found, own) * vector(&deltas, own).transpose();
            for other in (0..count).filter(|&other| is_edge(own, other)) {
                pull += rotations[other] * (2.0 * smoothing_mm2);
            }
            let svd = pull.svd(true, true);
            let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
            let upright = Vector3::new(1.0, 1.0, (u * v_t).determinant());
            rotations[own] = u * Matrix3::from_diagonal(&upright) * v_t;
        }
        energy = 0.0;
        for own in 0..count {
            let misfit = vector(&found, own) - rotations[own] * vector(&deltas, own);
            let others = (0..count).filter(|&other| is_edge(own, other));
            let bends = others.map(|other| (rotations[own] - rotations[other]).norm_squared());
            energy += misfit.norm_squared() + smoothing_mm2 * bends.sum::<f64>();
        }
        let ties = ties.iter();
        energy += ties
            .map(|(&vertex, place)| (vector(&places, vertex) - place).norm_squared())
            .sum::<f64>();
    }
    let place = |row: usize| Point3::from(vector(&places, row) / 1e3);
    (energy, (0..count).map(place).collect())
}

#[test]
fn the_printed_energy_is_that_of_dense_matrices_and_never_rises() {
    for (seed, smoothness) in [(51, 0.01), (52, 0.0)] {
        let (around, rings) = (8, 9);
        let mesh = tube(seed, around, rings);
        let held = rims(around, rings);
        let (handles, targets_m) = pinch(&mesh, around, 0.01);
        let settings = ArapSettings {
            smoothness,
            energy_change_min: 0.0,
            iterations_max: 19,
        };
        let source = Laplacian::new(&mesh, &held, settings).unwrap();
        let found = source.grip(&handles).unwrap().deform(&targets_m).unwrap();
        let mut ties: BTreeMap<usize, Vector3<f64>> = held
            .iter()
            .map(|&v| (v as usize, mesh.vertices[v as usize].coords.cast() * 1e3))
            .collect();
        let moved = handles.iter().zip(&targets_m);
        ties.extend(moved.map(|(&v, target)| (v as usize, target.coords * 1e3)));
        let smoothing_mm2 = smoothness * mesh.area_m2() * 1e6;
        let turns = found.energies_m2.len();
        let (slow_mm2, places_m) = slowly(&mesh, &ties, smoothing_mm2, turns);
        let relative = 1e6 * found.energy_m2 / slow_mm2 - 1.0;
        println!("smoothness {smoothness}: {slow_mm2} mm² after {turns} turns, {relative:e}");
        assert!(relative.abs() < 1e-6);
        assert!(apart_m(&found.vertices_m, &places_m) < 1e-7);
        let falls = found.energies_m2.windows(2);
        assert!(falls.clone().count() >= 2);
        for pair in falls {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-9), "{pair:?}");
        }
    }
}

#[test]
fn soft_constraints_give_way_and_hard_ones_do_not() {
    let (around, rings) = (8, 9);
    let mesh = tube(53, around, rings);
    let (held, settings) = (rims(around, rings), ArapSettings::default());
    let (handles, targets_m) = pinch(&mesh, around, 0.01);
    let soft = Laplacian::new(&mesh, &held, settings).unwrap();
    let soft = soft.grip(&handles).unwrap().deform(&targets_m).unwrap();
    let hard = Arap::new(&mesh, &held, settings).unwrap();
    let hard = hard.grip(&handles).unwrap().deform(&targets_m).unwrap();
    let misses = |places: &[Point3<f64>]| {
        let pairs = handles.iter().zip(&targets_m);
        let off = pairs.map(|(&handle, target)| (places[handle as usize] - target).norm());
        off.fold(0.0, f64::max)
    };
    assert!(misses(&hard.vertices_m) < 1e-12);
    assert!((1e-9..1e-3).contains(&misses(&soft.vertices_m)));
    // Where nothing is asked for, nothing moves.
    let rest = handles.map(|handle| mesh.vertices[handle as usize].cast());
    let source = Laplacian::new(&mesh, &held, settings).unwrap();
    let still = source.grip(&handles).unwrap().deform(&rest).unwrap();
    let source_m: Vec<Point3<f64>> = mesh.vertices.iter().map(|place| place.cast()).collect();
    assert!(apart_m(&still.vertices_m, &source_m) < 1e-9);
    assert!(source.grip(&held[..1]).is_err() && source.grip(&[9999]).is_err());
}
