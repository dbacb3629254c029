//! The energy of Eq. 3 letter by letter, beside the one that [`crate::Arap`] minimises:
//!
//! E = Σᵢ |δ(v'ᵢ) − Rᵢ·δ(vᵢ)|² + Σ |v'ₖ − cₖ|² + α·S·Σᵢ Σⱼ |Rᵢ−Rⱼ|²,
//!
//! δ being the cotangent Laplacian over the area of the Voronoi cell (Eq. 2), of the source's weights, and k running over held
//! vertices and handles, which are drawn to their places and not held there. Its terms have different units, so that the result
//! depends on that of length; it is the millimetre here, as in the paper's meshes.
//!
//! Rotations and places take turns, each being the best for the other, so that the energy never rises. For given rotations the
//! places solve one sparse linear system; a rotation is the polar factor of a 3 x 3 matrix.

use std::collections::BTreeMap;

use mesh::{Mesh, triangle};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::cholesky::{self, Cholesky};
use crate::error::ArapError;
use crate::grip::Deformed;
use crate::minimise::Stop;
use crate::one_ring::OneRings;
use crate::source::{ArapSettings, check, marked, singular};

const MM_PER_M: f64 = 1e3;
/// Least area of a cell, as a share of the mean: a vertex of triangles without area would outweigh all others.
const CELL_MIN: f64 = 1e-6;

/// A source mesh, ready to be deformed with the printed energy.
#[derive(Debug, Clone)]
pub struct Laplacian {
    /// δ as a matrix, 1/mm²: the entries of each row, its own vertex included.
    rows: Vec<BTreeMap<usize, f64>>,
    rest_mm: Vec<Vector3<f64>>,
    /// δ of the source, 1/mm.
    deltas: Vec<Vector3<f64>>,
    /// α·S, mm².
    smoothing_mm2: f64,
    held: Vec<bool>,
    settings: ArapSettings,
}

/// A source mesh with a set of handles to move.
#[derive(Debug, Clone)]
pub struct LaplacianGrip<'a> {
    source: &'a Laplacian,
    handles: Vec<usize>,
    /// Of the places' system, its vertices renumbered.
    factor: Cholesky,
    /// New number of each vertex.
    numbers: Vec<usize>,
}

impl Laplacian {
    /// Checks the mesh and computes its operator.
    ///
    /// # Errors
    /// As [`crate::Arap::new`].
    pub fn new(mesh: &Mesh, held: &[u32], settings: ArapSettings) -> Result<Self, ArapError> {
        check(&settings)?;
        let count = OneRings::new(mesh)?.len();
        let rest_mm = mesh.vertices.iter();
        let rest_mm: Vec<Vector3<f64>> = rest_mm
            .map(|place| place.coords.cast() * MM_PER_M)
            .collect();
        let rows = operator(&rest_mm, &mesh.triangles);
        Ok(Self {
            deltas: applied(&rows, &rest_mm),
            smoothing_mm2: settings.smoothness * mesh.area_m2() * MM_PER_M * MM_PER_M,
            held: marked(held, count, "held")?,
            rows,
            rest_mm,
            settings,
        })
    }

    /// Prepares moving these vertices.
    ///
    /// # Errors
    /// [`ArapError::NoSuchVertex`], [`ArapError::Repeated`] and [`ArapError::HeldHandle`] for unfit handles,
    /// [`ArapError::Singular`] where nothing ties a part of the mesh.
    pub fn grip(&self, handles: &[u32]) -> Result<LaplacianGrip<'_>, ArapError> {
        let moved = marked(handles, self.rows.len(), "a handle")?;
        if let Some(&vertex) = handles.iter().find(|&&handle| self.held[handle as usize]) {
            return Err(ArapError::HeldHandle { vertex });
        }
        let mut normal: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); self.rows.len()];
        for row in &self.rows {
            for (&one, a) in row {
                for (&other, b) in row {
                    *normal[one].entry(other as u32).or_default() += a * b;
                }
            }
        }
        let mut diagonal = Vec::with_capacity(normal.len());
        for (vertex, row) in normal.iter_mut().enumerate() {
            let tie = if self.held[vertex] || moved[vertex] {
                1.0
            } else {
                0.0
            };
            diagonal.push(row.remove(&(vertex as u32)).unwrap_or_default() + tie);
        }
        let pattern = OneRings::of_entries(normal);
        let order = cholesky::order(&pattern).map_err(singular("places"))?;
        let mut numbers = vec![0; order.len()];
        for (number, &vertex) in order.iter().enumerate() {
            numbers[vertex] = number;
        }
        let factor = Cholesky::new(
            &pattern.renamed(&order),
            |_| true,
            |number| diagonal[order[number]],
            |entry| entry,
        );
        Ok(LaplacianGrip {
            source: self,
            handles: handles.iter().map(|&handle| handle as usize).collect(),
            factor: factor.map_err(singular("places"))?,
            numbers,
        })
    }
}

impl LaplacianGrip<'_> {
    /// Draws the handles to `targets_m`, one each, in their order. [`Deformed::energy_m2`] is the printed energy of lengths in
    /// millimetres, divided by 10⁶.
    ///
    /// # Errors
    /// [`ArapError::TargetCount`], or [`ArapError::Target`] for one that is not finite.
    pub fn deform(&self, targets_m: &[Point3<f64>]) -> Result<Deformed, ArapError> {
        let ties = self.ties(targets_m)?;
        let source = self.source;
        let mut rotations = vec![Matrix3::identity(); source.rows.len()];
        let mut places_mm = source.rest_mm.clone();
        let mut energies_m2 = Vec::new();
        let stop = loop {
            self.settle(&rotations, &ties, &mut places_mm);
            source.turn(&places_mm, &mut rotations);
            let energy_m2 = source.energy_mm2(&places_mm, &rotations, &ties) / MM_PER_M.powi(2);
            let before = energies_m2.last().copied();
            energies_m2.push(energy_m2);
            let least = source.settings.energy_change_min * energy_m2;
            if before.is_some_and(|before: f64| before - energy_m2 <= least) {
                break Stop::EnergySettled;
            }
            if energies_m2.len() > source.settings.iterations_max {
                break Stop::IterationLimit;
            }
        };
        let place = |place: &Vector3<f64>| Point3::from(place / MM_PER_M);
        Ok(Deformed {
            vertices_m: places_mm.iter().map(place).collect(),
            energy_m2: energies_m2.last().copied().unwrap_or_default(),
            iterations: energies_m2.len() - 1,
            energies_m2,
            stop,
        })
    }

    /// Where held vertices and handles are drawn to, mm.
    fn ties(&self, targets_m: &[Point3<f64>]) -> Result<Vec<(usize, Vector3<f64>)>, ArapError> {
        if targets_m.len() != self.handles.len() {
            return Err(ArapError::TargetCount {
                targets: targets_m.len(),
                handles: self.handles.len(),
            });
        }
        let is_finite = |target: &Point3<f64>| target.iter().all(|part| part.is_finite());
        if let Some(index) = targets_m.iter().position(|target| !is_finite(target)) {
            return Err(ArapError::Target {
                index,
                target: targets_m[index],
                limit_m: f64::MAX,
            });
        }
        let held = self.source.held.iter().enumerate();
        let held = held.filter(|(_, held)| **held);
        let held = held.map(|(vertex, _)| (vertex, self.source.rest_mm[vertex]));
        let moved = self.handles.iter().zip(targets_m);
        let moved = moved.map(|(&vertex, target)| (vertex, target.coords * MM_PER_M));
        Ok(held.chain(moved).collect())
    }

    /// Sets the places that are best for the rotations.
    fn settle(
        &self,
        rotations: &[Matrix3<f64>],
        ties: &[(usize, Vector3<f64>)],
        places_mm: &mut [Vector3<f64>],
    ) {
        let source = self.source;
        let mut right = vec![[0.0; 4]; places_mm.len()];
        let mut add = |vertex: usize, part: Vector3<f64>| {
            let entry = &mut right[self.numbers[vertex]];
            (0..3).for_each(|axis| entry[axis] += part[axis]);
        };
        for (vertex, row) in source.rows.iter().enumerate() {
            let wanted = rotations[vertex] * source.deltas[vertex];
            row.iter()
                .for_each(|(&other, entry)| add(other, wanted * *entry));
        }
        ties.iter().for_each(|&(vertex, place)| add(vertex, place));
        self.factor.solve_lower(&mut right);
        self.factor.solve_upper(&mut right);
        for (place, &number) in places_mm.iter_mut().zip(&self.numbers) {
            let [x, y, z, _] = right[number];
            *place = Vector3::new(x, y, z);
        }
    }
}

impl Laplacian {
    /// Sets each rotation, one after the other, to the best for the places and its neighbours.
    fn turn(&self, places_mm: &[Vector3<f64>], rotations: &mut [Matrix3<f64>]) {
        let deltas = applied(&self.rows, places_mm);
        for (vertex, row) in self.rows.iter().enumerate() {
            let neighbours = row.keys().filter(|&&other| other != vertex);
            let sum: Matrix3<f64> = neighbours.map(|&other| rotations[other]).sum();
            let pull =
                deltas[vertex] * self.deltas[vertex].transpose() + sum * (2.0 * self.smoothing_mm2);
            if let Some(rotation) = nearest_rotation(&pull) {
                rotations[vertex] = rotation;
            }
        }
    }

    fn energy_mm2(
        &self,
        places_mm: &[Vector3<f64>],
        rotations: &[Matrix3<f64>],
        ties: &[(usize, Vector3<f64>)],
    ) -> f64 {
        let deltas = applied(&self.rows, places_mm);
        let of_vertex = |(vertex, row): (usize, &BTreeMap<usize, f64>)| {
            let misfit = deltas[vertex] - rotations[vertex] * self.deltas[vertex];
            let bends = row.keys();
            let bends = bends.map(|&other| (rotations[vertex] - rotations[other]).norm_squared());
            misfit.norm_squared() + self.smoothing_mm2 * bends.sum::<f64>()
        };
        let shape: f64 = self.rows.iter().enumerate().map(of_vertex).sum();
        let ties = ties.iter();
        let ties = ties.map(|&(vertex, place)| (places_mm[vertex] - place).norm_squared());
        shape + ties.sum::<f64>()
    }
}

/// δ (Eq. 2) as a matrix: cotangents of any sign over the areas of the Voronoi cells.
fn operator(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<BTreeMap<usize, f64>> {
    let mut rows: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); vertices.len()];
    let mut cells = vec![0.0; vertices.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| vertex as usize);
        let corners = [a, b, c].map(|vertex| Point3::from(vertices[vertex]));
        let cotangents = triangle::cotangents(corners);
        let parts = triangle::voronoi_areas(corners);
        for (k, (from, to)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
            cells[[a, b, c][k]] += parts[k];
            for (one, other) in [(from, to), (to, from)] {
                *rows[one].entry(other).or_default() -= 0.5 * cotangents[k];
                *rows[one].entry(one).or_default() += 0.5 * cotangents[k];
            }
        }
    }
    let least = CELL_MIN * cells.iter().sum::<f64>() / cells.len().max(1) as f64;
    for (row, cell) in rows.iter_mut().zip(cells) {
        row.values_mut().for_each(|entry| *entry /= cell.max(least));
    }
    rows
}

fn applied(rows: &[BTreeMap<usize, f64>], places: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let of_row = |row: &BTreeMap<usize, f64>| {
        row.iter()
            .map(|(&vertex, entry)| places[vertex] * *entry)
            .sum()
    };
    rows.iter().map(of_row).collect()
}

/// The rotation R for which tr(Rᵀ·`pull`) is largest; `None` where it has no singular values.
fn nearest_rotation(pull: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = pull.try_svd(true, true, f64::EPSILON, 0)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let upright = Vector3::new(1.0, 1.0, (u * v_t).determinant());
    Some(u * Matrix3::from_diagonal(&upright) * v_t)
}
