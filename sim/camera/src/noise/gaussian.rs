//! Gaussian numbers by the million.

use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64Mcg;

/// Gaussian numbers to draw from; a power of two that stays in the first-level cache.
const TABLE_LEN: usize = 4096;
const DRAW_BITS: u32 = TABLE_LEN.ilog2();
/// Numbers from one 64-bit draw.
const DRAWS_PER_WORD: usize = (64 / DRAW_BITS) as usize;
/// Pixels between the nodes of a smooth field.
const CELL_PX: usize = 4;

/// A fixed sample of the standard normal distribution with mean 0 and variance 1 exactly.
///
/// Drawing from it costs a table look-up, which keeps noise on every pixel of a 30 Hz stream cheap.
pub(super) struct GaussTable(Box<[f32; TABLE_LEN]>);

impl GaussTable {
    pub(super) fn new() -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(0);
        let mut table = Box::new([0.0; TABLE_LEN]);
        for pair in table.chunks_exact_mut(2) {
            let value: f32 = rng.sample(StandardNormal);
            pair.copy_from_slice(&[value, -value]);
        }
        let variance = table.iter().map(|value| value * value).sum::<f32>() / TABLE_LEN as f32;
        table.iter_mut().for_each(|value| *value /= variance.sqrt());
        Self(table)
    }

    /// Replaces each `x` by `own * g + shared * x` with a fresh Gaussian number `g`.
    pub(super) fn mix(&self, own: f32, shared: f32, values: &mut [f32], rng: &mut Pcg64Mcg) {
        for chunk in values.chunks_mut(DRAWS_PER_WORD) {
            let mut word: u64 = rng.random();
            for value in chunk {
                *value = own * self.0[word as usize % TABLE_LEN] + shared * *value;
                word >>= DRAW_BITS;
            }
        }
    }
}

/// Standard normal numbers at the nodes of a coarse grid, interpolated in between.
#[derive(Default)]
pub(super) struct SmoothField {
    nodes: Vec<f32>,
    columns: usize,
    blended: Vec<f32>,
}

impl SmoothField {
    /// Draws fresh nodes for an image.
    pub(super) fn draw(
        &mut self,
        width: usize,
        height: usize,
        gauss: &GaussTable,
        rng: &mut Pcg64Mcg,
    ) {
        self.columns = width / CELL_PX + 2;
        self.nodes.clear();
        self.nodes
            .resize(self.columns * (height / CELL_PX + 2), 0.0);
        gauss.mix(1.0, 0.0, &mut self.nodes, rng);
    }

    /// The field along image row `v`. Weights are scaled so that the variance is 1 between the nodes, too.
    pub(super) fn row(&mut self, v: usize, width: usize, values: &mut Vec<f32>) {
        let [upper, lower] = weights(v % CELL_PX);
        let first = v / CELL_PX * self.columns;
        let (above, below) = self.nodes[first..first + 2 * self.columns].split_at(self.columns);
        self.blended.clear();
        self.blended
            .extend(above.iter().zip(below).map(|(a, b)| upper * a + lower * b));
        values.clear();
        let inside: [[f32; 2]; CELL_PX] = std::array::from_fn(weights);
        for pair in self.blended.windows(2).take(width.div_ceil(CELL_PX)) {
            values.extend(
                inside
                    .iter()
                    .map(|[left, right]| left * pair[0] + right * pair[1]),
            );
        }
        values.truncate(width);
    }
}

/// Weights of the two nodes at `offset` pixels from the first, with squares that sum to 1.
fn weights(offset: usize) -> [f32; 2] {
    let share = offset as f32 / CELL_PX as f32;
    let norm = share.hypot(1.0 - share);
    [(1.0 - share) / norm, share / norm]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_and_variance(values: &[f32]) -> (f64, f64) {
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64;
        let variance = values
            .iter()
            .map(|&v| (f64::from(v) - mean).powi(2))
            .sum::<f64>()
            / values.len() as f64;
        (mean, variance)
    }

    #[test]
    fn the_table_is_standard_normal() {
        let table = GaussTable::new();
        let (mean, variance) = mean_and_variance(&*table.0);
        assert!(mean.abs() < 1e-6 && (variance - 1.0).abs() < 1e-4);
        let within = |limit: f32| {
            table.0.iter().filter(|v| v.abs() < limit).count() as f64 / TABLE_LEN as f64
        };
        assert!((within(1.0) - 0.6827).abs() < 0.02, "{}", within(1.0));
        assert!((within(2.0) - 0.9545).abs() < 0.01, "{}", within(2.0));
    }

    #[test]
    fn draws_and_the_smooth_field_have_unit_variance_everywhere() {
        let seed = 5;
        println!("seed {seed}");
        let (table, mut rng) = (GaussTable::new(), Pcg64Mcg::seed_from_u64(seed));
        let mut values = vec![0.0; 200_000];
        table.mix(1.0, 0.0, &mut values, &mut rng);
        let (mean, variance) = mean_and_variance(&values);
        assert!(
            mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02,
            "{mean} {variance}"
        );

        let (mut field, mut row) = (SmoothField::default(), Vec::new());
        let mut by_offset = vec![Vec::new(); CELL_PX];
        for _ in 0..40 {
            field.draw(400, 40, &table, &mut rng);
            for v in 0..40 {
                field.row(v, 399, &mut row);
                assert_eq!(row.len(), 399);
                (0..399).for_each(|u| by_offset[u % CELL_PX].push(row[u]));
            }
        }
        for values in by_offset {
            let (mean, variance) = mean_and_variance(&values);
            assert!(
                mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03,
                "{mean} {variance}"
            );
        }
    }
}
