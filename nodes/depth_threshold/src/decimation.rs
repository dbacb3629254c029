//! Decimation as in librealsense's `rs2::decimation_filter` for depth.

use crate::image::Depths;

/// Makes one pixel of each square of `factor` × `factor`: for factors 2 and 3 the median of those that are not 0 (of an
/// even count the lower middle one), from 4 on their mean (whole units stay whole, rounded down). Both sides of the
/// result are ⌊side / factor⌋ rounded up to a multiple of four, filled with 0.
pub(crate) fn decimate(from: &Depths, factor: usize, to: &mut Depths) {
    let (width, height) = (from.width / factor, from.height / factor);
    to.width = width.next_multiple_of(4);
    to.height = height.next_multiple_of(4);
    to.units_per_m = from.units_per_m;
    to.is_whole = from.is_whole;
    to.values.clear();
    to.values.resize(to.width * to.height, 0.0);

    let combine = if factor < 4 { lower_median } else { mean };
    let mut square = Vec::with_capacity(factor * factor);
    for (y, row) in to
        .values
        .chunks_exact_mut(to.width.max(1))
        .take(height)
        .enumerate()
    {
        for (x, pixel) in row.iter_mut().take(width).enumerate() {
            square.clear();
            for line in 0..factor {
                let line = &from.row(y * factor + line)[x * factor..][..factor];
                square.extend(line.iter().filter(|&&depth| depth > 0.0));
            }
            let combined = if square.is_empty() {
                0.0
            } else {
                combine(&mut square)
            };
            *pixel = if from.is_whole {
                combined.floor()
            } else {
                combined
            };
        }
    }
}

fn lower_median(depths: &mut [f32]) -> f32 {
    let middle = (depths.len() - 1) / 2;
    // Nine at most, for which insertion beats selection.
    depths.sort_unstable_by(f32::total_cmp);
    depths[middle]
}

fn mean(depths: &mut [f32]) -> f32 {
    depths.iter().sum::<f32>() / depths.len() as f32
}
