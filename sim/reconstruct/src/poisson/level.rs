//! One depth of the solver: values on the lattice places near the surface.

use std::ops::{Add, Mul};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::lattice::{self, Lattice, STEPS};

/// Lattice places with a value each: free ones, which the solver finds, and the ones around them, which it keeps.
pub(super) struct Level {
    pub depth: u32,
    pub lattice: Lattice,
    /// Cells, all of whose corners are in the lattice, sorted.
    pub cells: Vec<u64>,
    /// f at each place of the lattice.
    pub values: Vec<f64>,
    /// Indices of the free places.
    pub free: Vec<u32>,
    /// For each free place the indices of the nine places (x ± 1, y ± 1, z), of which the fifth is itself.
    pub rows: Vec<[u32; 9]>,
}

/// A point's eight lattice places, those of z and z + 1 in turn, and their shares of it.
#[derive(Clone, Copy)]
pub(super) struct Corners {
    pub indices: [u32; 4],
    pub shares: [f64; 8],
}

impl Corners {
    /// The trilinear interpolation of values.
    pub fn of(&self, values: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (pair, &index) in self.shares.chunks_exact(2).zip(&self.indices) {
            let index = index as usize;
            sum += pair[0] * values[index] + pair[1] * values[index + 1];
        }
        sum
    }

    /// Calls `give` with the index and the trilinear weight of each of the eight lattice points.
    pub fn spread(&self, mut give: impl FnMut(usize, f64)) {
        for (pair, &index) in self.shares.chunks_exact(2).zip(&self.indices) {
            give(index as usize, pair[0]);
            give(index as usize + 1, pair[1]);
        }
    }
}

impl Level {
    /// A level whose free places are the corners of these cells, inside the unit cube. Values are all `outside`.
    pub fn new(depth: u32, cells: Vec<u64>, outside: f64) -> Self {
        let inside = 1..1 << depth;
        let mut free = lattice::corners(&cells);
        free.retain(|&key| {
            let place = lattice::place(key);
            place.iter().all(|coordinate| inside.contains(coordinate))
        });
        let all = lattice::union(
            &lattice::dilated(&free),
            lattice::corners(&cells).into_iter(),
        );
        let lattice = Lattice::new(all);
        // Every neighbour is in the lattice, since the set is dilated.
        let index = |key: u64| lattice.find(key).unwrap_or_default();
        let rows = free
            .par_iter()
            .map(|&key| {
                let mut row = [0; 9];
                for (at, index_of) in row.iter_mut().enumerate() {
                    let (x, y) = (at as u64 / 3, at as u64 % 3);
                    *index_of = index(key + x * STEPS[0] + y * STEPS[1] - STEPS[0] - STEPS[1]);
                }
                row
            })
            .collect();
        Self {
            depth,
            values: vec![outside; lattice.keys().len()],
            free: free.iter().map(|&key| index(key)).collect(),
            lattice,
            cells,
            rows,
        }
    }

    /// Side of a cell, as a share of the unit cube's.
    pub fn cell(&self) -> f64 {
        cell(self.depth)
    }

    /// The lattice places around a point of the unit cube; `None` where one is missing.
    pub fn corners(&self, point: &Point3<f64>) -> Option<Corners> {
        let scaled = point.coords / self.cell();
        let low = scaled.map(f64::floor);
        let base = lattice::key([low.x as i32, low.y as i32, low.z as i32]);
        let part = scaled - low;
        let mut corners = Corners {
            indices: [0; 4],
            shares: [0.0; 8],
        };
        for at in 0..4 {
            let (x, y) = (at >> 1, at & 1);
            let key = base + x as u64 * STEPS[0] + y as u64 * STEPS[1];
            let index = self.lattice.find(key)?;
            if self.lattice.keys().get(index as usize + 1) != Some(&(key + 1)) {
                return None;
            }
            let share = |upper: usize, part: f64| if upper == 1 { part } else { 1.0 - part };
            let flat = share(x, part.x) * share(y, part.y);
            corners.indices[at] = index;
            corners.shares[2 * at] = flat * (1.0 - part.z);
            corners.shares[2 * at + 1] = flat * part.z;
        }
        Some(corners)
    }

    /// f at the eight corners of a cell (bits x, y, z of the number from the highest); `None` where one is missing.
    pub fn cell_values(&self, cell: u64) -> Option<[f64; 8]> {
        let mut values = [0.0; 8];
        for (at, pair) in values.chunks_exact_mut(2).enumerate() {
            let key = cell + (at as u64 >> 1) * STEPS[0] + (at as u64 & 1) * STEPS[1];
            let index = self.lattice.find(key)? as usize;
            pair.copy_from_slice(self.values.get(index..index + 2)?);
        }
        Some(values)
    }

    /// f and its gradient at a point of the unit cube; `None` away from the cells.
    pub fn value_and_gradient(&self, point: &Point3<f64>) -> Option<(f64, Vector3<f64>)> {
        let corners = self.corners(point)?;
        let part = point.coords / self.cell();
        let part = part - part.map(f64::floor);
        let mut gradient = Vector3::zeros();
        for corner in 0..8 {
            let value = self.values[corners.indices[corner >> 1] as usize + (corner & 1)];
            let is_upper = [corner & 4 != 0, corner & 2 != 0, corner & 1 != 0];
            let share = |axis: usize| {
                if is_upper[axis] {
                    part[axis]
                } else {
                    1.0 - part[axis]
                }
            };
            let sign = |axis: usize| if is_upper[axis] { 1.0 } else { -1.0 };
            gradient.x += value * sign(0) * share(1) * share(2);
            gradient.y += value * share(0) * sign(1) * share(2);
            gradient.z += value * share(0) * share(1) * sign(2);
        }
        Some((corners.of(&self.values), gradient / self.cell()))
    }

    /// Values given at a coarser level's places, interpolated at this one's; `None` where one is missing.
    pub fn interpolated<T>(&self, coarse: &Level, values: &[T]) -> Vec<Option<T>>
    where
        T: Copy + Send + Sync + Add<Output = T> + Mul<f64, Output = T>,
    {
        let at = |&key: &u64| {
            let place = lattice::place(key);
            let base = lattice::key(place.map(|coordinate| coordinate.div_euclid(2)));
            let is_odd = place.map(|coordinate| coordinate.rem_euclid(2) as u64);
            let mut sum: Option<T> = None;
            let mut count = 0.0;
            for [x, y, z] in (0..8).map(|bits| [bits >> 2, bits >> 1 & 1, bits & 1]) {
                if x > is_odd[0] || y > is_odd[1] || z > is_odd[2] {
                    continue;
                }
                let parent = base + x * STEPS[0] + y * STEPS[1] + z * STEPS[2];
                let value = values[coarse.lattice.find(parent)? as usize];
                sum = Some(sum.map_or(value, |sum| sum + value));
                count += 1.0;
            }
            sum.map(|sum| sum * (1.0 / count))
        };
        self.lattice.keys().par_iter().map(at).collect()
    }
}

/// Side of a cell at a depth, as a share of the unit cube's.
pub(super) fn cell(depth: u32) -> f64 {
    1.0 / f64::from(1_u32 << depth)
}
