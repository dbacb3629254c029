//! Noise of a D435i.
//!
//! A stereo camera measures disparity `d = f B / z`. An error of `disparity_sigma_px` pixels in it is an
//! error of `z^2 * disparity_sigma_px / (f B)` metres in depth; disparity comes in steps of 1/32 px, and depth in
//! millimetres.

mod gaussian;

use parameter::{ParameterError, check_ranges};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::image::{DepthImage, InverseDepth};
use crate::intrinsics::Intrinsics;
use crate::stereo::{Edges, Nearness, UNSEEN};
use gaussian::{GaussTable, SmoothField};

/// Disparity steps per pixel.
const STEPS_PER_PX: f32 = 32.0;
/// Largest disparity that the camera searches; what is nearer is not measured.
const DISPARITY_MAX_PX: f32 = 126.0;

/// How good the camera is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseParameters {
    /// Standard deviation of disparity, in pixels (0 to 2).
    pub disparity_sigma_px: f64,
    /// Share of the disparity's variance that neighbouring pixels have in common, 0 to 1. Matching
    /// windows overlap, so that a measured surface is wavy rather than rough.
    pub correlated_share: f64,
    /// Distance between the imagers, in metres (0.005 to 0.5).
    pub baseline_m: f64,
    /// Chance that a pixel beside a depth edge is not measured, 0 to 1; half of it one pixel further.
    pub edge_dropout: f64,
    /// Chance that a pixel beside a depth edge lies somewhere between the two surfaces, 0 to 1.
    pub edge_mixing: f64,
}

impl Default for NoiseParameters {
    fn default() -> Self {
        Self {
            disparity_sigma_px: 0.08,
            correlated_share: 0.5,
            baseline_m: 0.04986,
            edge_dropout: 0.4,
            edge_mixing: 0.15,
        }
    }
}

impl NoiseParameters {
    /// Checks every value against its range.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_ranges! { self;
            disparity_sigma_px: 0.0..=2.0, "pixels";
            correlated_share: 0.0..=1.0;
            baseline_m: 0.005..=0.5, "m";
            edge_dropout: 0.0..=1.0;
            edge_mixing: 0.0..=1.0;
        }
        Ok(())
    }
}

/// A source of noise; the same seed gives the same sequence of images.
pub struct Noise {
    parameters: NoiseParameters,
    rng: Pcg64Mcg,
    gauss: GaussTable,
    field: SmoothField,
    depths: DepthTable,
    edges: Edges,
    row: RowBuffers,
}

/// Scratch space for one row.
#[derive(Default)]
struct RowBuffers {
    disparity_px: Vec<f32>,
    nearest_px: Vec<f32>,
    error: Vec<f32>,
}

impl Noise {
    /// Noise drawn from `seed`.
    ///
    /// # Errors
    /// A parameter that is out of range.
    pub fn new(parameters: NoiseParameters, seed: u64) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self {
            parameters,
            rng: Pcg64Mcg::seed_from_u64(seed),
            gauss: GaussTable::new(),
            field: SmoothField::default(),
            depths: DepthTable::new(),
            edges: Edges::default(),
            row: RowBuffers::default(),
        })
    }

    /// What the camera makes of a view. Each call draws fresh noise.
    pub fn apply(&mut self, clean: &InverseDepth, camera: &Intrinsics) -> DepthImage {
        let mut image = DepthImage::empty(clean.width, clean.height);
        let px_m = (camera.fx * self.parameters.baseline_m) as f32;
        self.depths.prepare(px_m);
        self.edges.find(clean, px_m);
        self.field
            .draw(clean.width, clean.height, &self.gauss, &mut self.rng);
        for (v, depth_mm) in image.depth_mm.chunks_exact_mut(clean.width).enumerate() {
            let row = &mut self.row;
            row.disparity_px.clear();
            row.disparity_px
                .extend(clean.row(v).iter().map(|per_m| per_m * px_m));
            self.edges
                .hide_unseen(v, &mut row.disparity_px, &mut row.nearest_px);
            self.disturb_edges(clean, v, px_m);
            self.measure_row(v, depth_mm);
        }
        image
    }

    /// Drops pixels at depth edges of row `v`, or mixes the two sides' disparities.
    fn disturb_edges(&mut self, clean: &InverseDepth, v: usize, px_m: f32) {
        let marks = self.edges.row(v);
        for (u, own_px) in self.row.disparity_px.iter_mut().enumerate() {
            if marks[u] == Nearness::Smooth || *own_px == UNSEEN {
                continue;
            }
            let chance: f64 = self.rng.random();
            let at_edge = marks[u] == Nearness::Edge;
            let dropout = self.parameters.edge_dropout * if at_edge { 1.0 } else { 0.5 };
            if chance < dropout {
                *own_px = UNSEEN;
            } else if at_edge && chance < dropout + self.parameters.edge_mixing {
                let other_px = across_edge(clean, u, v) * px_m;
                let share: f32 = self.rng.random();
                *own_px += share * (other_px - *own_px);
            }
        }
    }

    /// Adds the disparity's error to a row and converts it to millimetres.
    fn measure_row(&mut self, v: usize, depth_mm: &mut [u16]) {
        let sigma_steps = self.parameters.disparity_sigma_px as f32 * STEPS_PER_PX;
        let shared = self.parameters.correlated_share as f32;
        let (own_steps, shared_steps) = (
            sigma_steps * (1.0 - shared).sqrt(),
            sigma_steps * shared.sqrt(),
        );
        let row = &mut self.row;
        self.field.row(v, depth_mm.len(), &mut row.error);
        self.gauss
            .mix(own_steps, shared_steps, &mut row.error, &mut self.rng);
        for ((depth_mm, disparity_px), error) in
            depth_mm.iter_mut().zip(&row.disparity_px).zip(&row.error)
        {
            *depth_mm = self.depths.mm(disparity_px * STEPS_PER_PX + error);
        }
    }
}

/// Inverse depth of the neighbour that differs most from the pixel.
fn across_edge(clean: &InverseDepth, u: usize, v: usize) -> f32 {
    let own = clean.row(v)[u];
    let beside = [u.checked_sub(1), Some(u + 1)].into_iter().flatten();
    let above_below = [v.checked_sub(1), Some(v + 1).filter(|&v| v < clean.height)]
        .into_iter()
        .flatten();
    beside
        .filter_map(|u| clean.row(v).get(u))
        .chain(above_below.map(|v| &clean.row(v)[u]))
        .copied()
        .filter(|per_m| *per_m > 0.0)
        .fold(own, |best, per_m| {
            if (per_m - own).abs() > (best - own).abs() {
                per_m
            } else {
                best
            }
        })
}

/// Depth in millimetres by disparity in steps; 0 at either end of the range and beyond.
struct DepthTable {
    px_m: f32,
    depth_mm: Box<[u16; DEPTHS]>,
}

/// Power of two above the number of steps, so that an index needs no check.
const DEPTHS: usize = 8192;
const STEPS_END: f32 = DISPARITY_MAX_PX * STEPS_PER_PX + 1.0;

impl DepthTable {
    fn new() -> Self {
        Self {
            px_m: 0.0,
            depth_mm: Box::new([0; DEPTHS]),
        }
    }

    fn prepare(&mut self, px_m: f32) {
        if self.px_m != px_m {
            self.px_m = px_m;
            for steps in 1..STEPS_END as usize {
                self.depth_mm[steps] = crate::image::to_mm(steps as f32 / (STEPS_PER_PX * px_m));
            }
        }
    }

    /// Depth for a disparity, rounded to a whole step.
    fn mm(&self, steps: f32) -> u16 {
        // At 2^23 a float's last bit is worth 1: adding it rounds, and the integer is in the low bits. This is much
        // quicker than a saturating conversion.
        let rounded = steps.clamp(0.0, STEPS_END) + 8_388_608.0;
        self.depth_mm[rounded.to_bits() as usize % DEPTHS]
    }
}

#[cfg(test)]
mod tests;
