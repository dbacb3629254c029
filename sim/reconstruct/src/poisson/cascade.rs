//! Coarse to fine: each level starts from the solution of the one before.

use nalgebra::{Point3, Vector3};

use super::Sample;
use super::lattice;
use super::level::Level;
use super::solve::{Pin, solve};

/// Deepest level that covers the whole cube; deeper ones cover the neighbourhood of the surface only.
pub(super) const DEPTH_FULL: u32 = 5;
/// Value of f far outside.
const OUTSIDE: f64 = 0.5;
/// A level is solved when the residual's norm is this share of the right-hand side's.
const TOLERANCE: f64 = 1e-3;
const STEPS_MAX: usize = 100;

/// The finest level so far, and the vector field V on it.
pub(super) struct Cascade<'a> {
    samples: &'a [Sample],
    screening: f64,
    /// Deepest level at which V is splatted from the samples. Finer levels interpolate it from there, since their cells
    /// between samples would get none.
    spread_depth: u32,
    pub level: Level,
    field: Vec<Vector3<f64>>,
}

impl<'a> Cascade<'a> {
    /// Solves the first level. Samples are in the unit cube.
    pub fn new(samples: &'a [Sample], screening: f64, spread_depth: u32, depth: u32) -> Self {
        let mut cascade = Self {
            samples,
            screening,
            spread_depth,
            level: Level::new(depth, all_cells(depth), OUTSIDE),
            field: Vec::new(),
        };
        cascade.field = spread(samples, &cascade.level);
        cascade.solve();
        cascade
    }

    /// Refines by one depth. `is_near` tells whether the surface is to be refined at a point.
    pub fn refine(&mut self, is_near: impl Fn(&Point3<f64>) -> bool) {
        let depth = self.level.depth + 1;
        let cells = if depth <= DEPTH_FULL {
            all_cells(depth)
        } else {
            lattice::dilated(&lattice::children(&self.cells_to_refine(is_near)))
        };
        let mut level = Level::new(depth, cells, OUTSIDE);
        let values = level.interpolated(&self.level, &self.level.values);
        for (value, found) in level.values.iter_mut().zip(values) {
            *value = found.unwrap_or(*value);
        }
        self.field = if depth <= self.spread_depth {
            spread(self.samples, &level)
        } else {
            let field = level.interpolated(&self.level, &self.field);
            field.into_iter().map(Option::unwrap_or_default).collect()
        };
        self.level = level;
        self.solve();
    }

    fn solve(&mut self) {
        let weight = self.screening / self.level.cell();
        let pins: Vec<Pin> = self
            .samples
            .iter()
            .filter_map(|sample| {
                let corners = self.level.corners(&sample.point)?;
                let weight = weight * sample.area;
                Some(Pin { corners, weight })
            })
            .collect();
        solve(&mut self.level, &self.field, &pins, TOLERANCE, STEPS_MAX);
    }

    /// Cells with a sample in them, and cells that the surface crosses near one.
    fn cells_to_refine(&self, is_near: impl Fn(&Point3<f64>) -> bool) -> Vec<u64> {
        let side = self.level.cell();
        let cell_of = |sample: &Sample| {
            let place = sample.point.coords / side;
            lattice::key([place.x, place.y, place.z].map(|coordinate| coordinate as i32))
        };
        let mut with_sample: Vec<u64> = self.samples.iter().map(cell_of).collect();
        with_sample.sort_unstable();
        with_sample.dedup();
        let centre = |cell: u64| {
            let middle = lattice::place(cell).map(|coordinate| f64::from(coordinate) + 0.5);
            Point3::from(Vector3::from(middle) * side)
        };
        let crossed = self.level.cells.iter().copied().filter(|&cell| {
            let values = self.level.cell_values(cell);
            let is_inside = |values: [f64; 8]| values.iter().filter(|&&f| f < 0.0).count();
            values.is_some_and(|values| (1..8).contains(&is_inside(values)))
                && is_near(&centre(cell))
        });
        lattice::union(&with_sample, crossed)
    }
}

pub(super) fn all_cells(depth: u32) -> Vec<u64> {
    let range = 0..1_i32 << depth;
    let mut cells = Vec::with_capacity(1 << (3 * depth));
    for x in range.clone() {
        for y in range.clone() {
            cells.extend(range.clone().map(|z| lattice::key([x, y, z])));
        }
    }
    cells
}

/// Splats the samples' normals onto the lattice: V is a sum of trilinear hat functions, each with the sample's area as its
/// integral.
fn spread(samples: &[Sample], level: &Level) -> Vec<Vector3<f64>> {
    let mut field = vec![Vector3::zeros(); level.values.len()];
    let per_volume = level.cell().powi(-3);
    for sample in samples {
        if let Some(corners) = level.corners(&sample.point) {
            let normal = sample.normal * (sample.area * per_volume);
            corners.spread(|place, share| field[place] += normal * share);
        }
    }
    field
}
