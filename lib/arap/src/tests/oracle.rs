//! A slow way to the same minimum: dense matrices, one rotation after the other, until nothing changes.

use std::collections::BTreeMap;

use mesh::Mesh;
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};

use super::{apart_m, pinch, rims, tube};
use crate::{Arap, ArapSettings};

struct Oracle {
    rest_m: Vec<Vector3<f64>>,
    /// Both directions of each edge.
    weights: BTreeMap<(usize, usize), f64>,
    smoothing_m2: f64,
    rotations: Vec<Matrix3<f64>>,
    places_m: Vec<Vector3<f64>>,
}

impl Oracle {
    fn new(mesh: &Mesh, smoothness: f64) -> Self {
        let rest_m: Vec<Vector3<f64>> = mesh
            .vertices
            .iter()
            .map(|place| place.coords.cast())
            .collect();
        let mut cotangents: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
        let mut area_m2 = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| vertex as usize);
            for [apex, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
                let angle = (rest_m[from] - rest_m[apex]).angle(&(rest_m[to] - rest_m[apex]));
                cotangents
                    .entry((from, to))
                    .or_default()
                    .push(1.0 / angle.tan());
                cotangents
                    .entry((to, from))
                    .or_default()
                    .push(1.0 / angle.tan());
            }
            area_m2 += (rest_m[b] - rest_m[a])
                .cross(&(rest_m[c] - rest_m[a]))
                .norm()
                / 2.0;
        }
        let mean = |all: Vec<f64>| (all.iter().sum::<f64>() / all.len() as f64).max(0.0);
        let weights: BTreeMap<_, _> = cotangents
            .into_iter()
            .map(|(edge, all)| (edge, mean(all)))
            .collect();
        assert!(
            weights.values().any(|&weight| weight == 0.0),
            "no obtuse angles"
        );
        Self {
            rotations: vec![Matrix3::identity(); rest_m.len()],
            places_m: rest_m.clone(),
            smoothing_m2: smoothness * area_m2,
            weights,
            rest_m,
        }
    }

    fn energy_m2(&self) -> f64 {
        let edge = |(&(i, j), weight): (&(usize, usize), &f64)| {
            let rest = self.rest_m[i] - self.rest_m[j];
            let misfit = self.places_m[i] - self.places_m[j] - self.rotations[i] * rest;
            let bend = (self.rotations[i] - self.rotations[j]).norm_squared();
            weight * misfit.norm_squared() + self.smoothing_m2 * bend
        };
        self.weights.iter().map(edge).sum()
    }

    fn turn(&mut self) {
        for vertex in 0..self.rest_m.len() {
            let mut pull = Matrix3::zeros();
            for (&(_, other), &weight) in self.weights.range((vertex, 0)..(vertex + 1, 0)) {
                let rest = self.rest_m[vertex] - self.rest_m[other];
                let place = self.places_m[vertex] - self.places_m[other];
                pull += place * rest.transpose() * weight
                    + self.rotations[other] * (2.0 * self.smoothing_m2);
            }
            let svd = pull.svd(true, true);
            let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
            let upright = Vector3::new(1.0, 1.0, (u * v_t).determinant());
            self.rotations[vertex] = u * Matrix3::from_diagonal(&upright) * v_t;
        }
    }

    /// Places that are best for the rotations, with some fixed. `inverse` is of the system of `fixed`.
    fn place(&mut self, inverse: &DMatrix<f64>, fixed: &BTreeMap<usize, Vector3<f64>>) {
        let mut right = DMatrix::zeros(self.rest_m.len(), 3);
        for (&(i, j), weight) in &self.weights {
            let both = (self.rotations[i] + self.rotations[j]) / 2.0;
            let pull = both * (self.rest_m[i] - self.rest_m[j]) * *weight;
            (0..3).for_each(|axis| right[(i, axis)] += pull[axis]);
        }
        for (&vertex, place) in fixed {
            (0..3).for_each(|axis| right[(vertex, axis)] = place[axis]);
        }
        let places = inverse * right;
        self.places_m = places
            .row_iter()
            .map(|row| Vector3::new(row[0], row[1], row[2]))
            .collect();
    }

    fn settle(&mut self, fixed: &BTreeMap<usize, Vector3<f64>>) -> f64 {
        let count = self.rest_m.len();
        let mut system = DMatrix::<f64>::zeros(count, count);
        for (&(i, j), weight) in self
            .weights
            .iter()
            .filter(|((i, _), _)| !fixed.contains_key(i))
        {
            system[(i, i)] += weight;
            system[(i, j)] -= weight;
        }
        fixed
            .keys()
            .for_each(|&vertex| system[(vertex, vertex)] = 1.0);
        let inverse = system.try_inverse().unwrap();
        let mut energy_m2 = f64::MAX;
        for _ in 0..20_000 {
            self.turn();
            self.place(&inverse, fixed);
            let before = std::mem::replace(&mut energy_m2, self.energy_m2());
            if before - energy_m2 < 1e-13 * energy_m2 {
                break;
            }
        }
        energy_m2
    }
}

#[test]
fn the_slow_way_leads_to_the_same_energy_and_places() {
    for (seed, smoothness) in [(21, 0.01), (22, 0.0), (23, 1e-4)] {
        let (around, rings) = (8, 9);
        let mesh = tube(seed, around, rings);
        let held = rims(around, rings);
        let (handles, targets_m) = pinch(&mesh, around, 0.01);
        let settings = ArapSettings {
            smoothness,
            energy_change_min: 1e-12,
            iterations_max: 1000,
        };
        let arap = Arap::new(&mesh, &held, settings).unwrap();
        let fast = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
        let mut oracle = Oracle::new(&mesh, smoothness);
        let mut fixed: BTreeMap<_, _> = held
            .iter()
            .map(|&v| (v as usize, oracle.rest_m[v as usize]))
            .collect();
        fixed.extend(
            handles
                .iter()
                .zip(&targets_m)
                .map(|(&v, target)| (v as usize, target.coords)),
        );
        let slow_m2 = oracle.settle(&fixed);
        let relative = fast.energy_m2 / slow_m2 - 1.0;
        println!(
            "smoothness {smoothness}: {:e} m², {relative:e} more than the slow way",
            fast.energy_m2
        );
        assert!(relative < 1e-7, "{relative}");
        assert!(relative > -1e-6, "{relative}");
        let slow: Vec<Point3<f64>> = oracle.places_m.iter().map(|&place| place.into()).collect();
        assert!(
            apart_m(&fast.vertices_m, &slow) < 1e-5,
            "{}",
            apart_m(&fast.vertices_m, &slow)
        );
        let least_m2 = arap.energy_m2(&slow).unwrap();
        assert!(
            (least_m2 / slow_m2 - 1.0).abs() < 1e-6,
            "{least_m2} {slow_m2}"
        );
    }
}
