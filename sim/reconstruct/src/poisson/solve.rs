//! The linear system of one level: trilinear finite elements, solved by preconditioned conjugate gradients.
//!
//! f is a sum of trilinear hat functions, one for each lattice point. It minimises the screened Poisson energy of Kazhdan
//! and Hoppe (ACM Trans. Graph. 32, 2013), ∫‖V − ∇f‖² + α/h Σ area (f(sample))². As there, the screening weight α/h doubles
//! with each depth.
//!
//! For cells of side h the integral of the product of two hats' gradients is h times 8/3 for a hat with itself, 0 for
//! neighbours along an axis, −1/6 for neighbours across a face's diagonal and −1/12 across a cell's.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::level::{Corners, Level};

/// Rows that one thread computes at a time. Fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// A sample's screening term: f is to be 0 there.
pub(super) struct Pin {
    pub corners: Corners,
    /// Area of the surface that it stands for, times the screening weight.
    pub weight: f64,
}

/// Solves for the free values by conjugate gradients, starting from the present ones, until the residual's norm is
/// `tolerance` times the right-hand side's.
///
/// `field` holds V at each place. Returns the number of conjugate-gradient steps.
pub(super) fn solve(
    level: &mut Level,
    field: &[Vector3<f64>],
    pins: &[Pin],
    tolerance: f64,
    steps_max: usize,
) -> usize {
    let diagonal = diagonal(level, pins);
    let mut product = vec![0.0; level.free.len()];
    let wanted = divergence(level, field);
    let scale = norm_squared(&wanted).max(f64::MIN_POSITIVE);
    apply(level, &level.values, pins, &mut product);
    let mut residual: Vec<f64> = wanted.iter().zip(&product).map(|(b, ax)| b - ax).collect();
    let mut scaled: Vec<f64> = residual.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    // One entry for every lattice point, since the stencil reaches fixed points; only free ones ever differ from 0.
    let mut direction = vec![0.0; level.values.len()];
    let mut rho = dot(&residual, &scaled);
    let mut last_rho = f64::INFINITY;
    for step in 0..steps_max {
        if norm_squared(&residual) <= tolerance * tolerance * scale {
            return step;
        }
        let beta = rho / last_rho;
        for (&place, z) in level.free.iter().zip(&scaled) {
            let d = &mut direction[place as usize];
            *d = z + beta * *d;
        }
        apply(level, &direction, pins, &mut product);
        let moved: Vec<f64> = level
            .free
            .iter()
            .map(|&place| direction[place as usize])
            .collect();
        let alpha = rho / dot(&moved, &product).max(f64::MIN_POSITIVE);
        for (&place, d) in level.free.iter().zip(&moved) {
            level.values[place as usize] += alpha * d;
        }
        for at in 0..residual.len() {
            residual[at] -= alpha * product[at];
            scaled[at] = residual[at] / diagonal[at];
        }
        last_rho = rho;
        rho = dot(&residual, &scaled);
    }
    steps_max
}

/// ∫∇hat · V for each free place.
fn divergence(level: &Level, field: &[Vector3<f64>]) -> Vec<f64> {
    let area = level.cell() * level.cell();
    // Integrals of a hat with its neighbours and itself, as shares of h.
    const MASS: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];
    // Integral of a hat's slope with its neighbours.
    const SLOPE: [f64; 3] = [0.5, 0.0, -0.5];
    let at = |row: &[u32; 9]| {
        let mut sum = 0.0;
        for (at, &centre) in row.iter().enumerate() {
            let (x, y) = (at / 3, at % 3);
            for z in 0..3 {
                let v = &field[centre as usize + z - 1];
                sum += v.x * SLOPE[x] * MASS[y] * MASS[z]
                    + v.y * MASS[x] * SLOPE[y] * MASS[z]
                    + v.z * MASS[x] * MASS[y] * SLOPE[z];
            }
        }
        sum * area
    };
    level.rows.par_iter().with_min_len(CHUNK).map(at).collect()
}

/// The system's matrix times values given at all places, at the free ones.
fn apply(level: &Level, values: &[f64], pins: &[Pin], product: &mut [f64]) {
    let side = level.cell();
    let at = |row: &[u32; 9]| {
        let place = |at: usize| row[at] as usize;
        let ends = |at: usize| values[place(at) - 1] + values[place(at) + 1];
        let across_faces = ends(1)
            + ends(3)
            + ends(5)
            + ends(7)
            + values[place(0)]
            + values[place(2)]
            + values[place(6)]
            + values[place(8)];
        let across_cells = ends(0) + ends(2) + ends(6) + ends(8);
        side * (8.0 / 3.0 * values[place(4)] - across_faces / 6.0 - across_cells / 12.0)
    };
    product
        .par_iter_mut()
        .zip(&level.rows)
        .with_min_len(CHUNK)
        .for_each(|(product, row)| *product = at(row));
    let mut pinned = vec![0.0; values.len()];
    for pin in pins {
        let pull = pin.weight * pin.corners.of(values);
        pin.corners
            .spread(|place, share| pinned[place] += share * pull);
    }
    for (product, &place) in product.iter_mut().zip(&level.free) {
        *product += pinned[place as usize];
    }
}

fn diagonal(level: &Level, pins: &[Pin]) -> Vec<f64> {
    let mut pinned = vec![8.0 / 3.0 * level.cell(); level.values.len()];
    for pin in pins {
        let spread = |place: usize, share: f64| pinned[place] += pin.weight * share * share;
        pin.corners.spread(spread);
    }
    level
        .free
        .iter()
        .map(|&place| pinned[place as usize])
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let parts: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum())
        .collect();
    parts.iter().sum()
}

fn norm_squared(a: &[f64]) -> f64 {
    dot(a, a)
}
