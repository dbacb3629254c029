//! What a stereo pair cannot see.
//!
//! The depth image is the left imager's; the right imager is one baseline to its right. A point at column u with
//! disparity d is at column u - d in the right image.

use crate::image::InverseDepth;

/// Disparity of a pixel without measurement. No error that is added makes it one.
pub(crate) const UNSEEN: f32 = f32::NEG_INFINITY;

/// Farther than this behind the surface that the right imager sees, a point is hidden from it.
const HIDDEN_PX: f32 = 1.0;
/// Disparity step between neighbours that counts as an edge. A surface seen at a grazing angle has one, too. Smaller
/// than [`HIDDEN_PX`], so that a row without a rising step has no hidden point.
const EDGE_PX: f32 = 0.75;

/// How near a pixel is to a depth edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Nearness {
    /// Away from edges.
    Smooth = 0,
    /// One pixel further than `Edge`.
    Near = 1,
    /// Beside the step itself.
    Edge = 2,
}

/// Depth edges of one view.
#[derive(Default)]
pub(crate) struct Edges {
    width: usize,
    marks: Vec<Nearness>,
    /// By row, the first and the last column whose right neighbour is nearer by a step.
    rising: Vec<Option<(usize, usize)>>,
}

impl Edges {
    /// Finds the edges of a view; `px_m` is disparity over inverse depth (focal length times baseline).
    pub(crate) fn find(&mut self, image: &InverseDepth, px_m: f32) {
        let (width, height) = (image.width, image.height);
        let step_per_m = EDGE_PX / px_m;
        self.width = width;
        self.marks.clear();
        self.marks.resize(width * height, Nearness::Smooth);
        self.rising.clear();
        for v in 0..height {
            let row = image.row(v);
            let mut rising: Option<(usize, usize)> = None;
            for (u, pair) in row.windows(2).enumerate() {
                if (pair[0] - pair[1]).abs() > step_per_m {
                    self.mark(v * width + u, 1, u, width - 1 - u);
                    if pair[1] > pair[0] {
                        rising = Some((rising.map_or(u, |(first, _)| first), u));
                    }
                }
            }
            self.rising.push(rising);
            if v + 1 < height {
                for (u, (upper, lower)) in row.iter().zip(image.row(v + 1)).enumerate() {
                    if (upper - lower).abs() > step_per_m {
                        self.mark(v * width + u, width, v, height - 1 - v);
                    }
                }
            }
        }
    }

    /// Marks the two pixels at a step between `index` and `index + stride`, and one more on either side.
    fn mark(&mut self, index: usize, stride: usize, before: usize, after: usize) {
        let mut raise =
            |index: usize, nearness| self.marks[index] = self.marks[index].max(nearness);
        raise(index, Nearness::Edge);
        raise(index + stride, Nearness::Edge);
        if before >= 1 {
            raise(index - stride, Nearness::Near);
        }
        if after >= 2 {
            raise(index + 2 * stride, Nearness::Near);
        }
    }

    /// The marks of row `v`.
    pub(crate) fn row(&self, v: usize) -> &[Nearness] {
        &self.marks[v * self.width..][..self.width]
    }

    /// Makes pixels of row `v` [`UNSEEN`] that only the left imager sees: those left of the right imager's view (the
    /// blind band on the left) and those in the shadow of something nearer.
    pub(crate) fn hide_unseen(
        &self,
        v: usize,
        disparity_px: &mut [f32],
        nearest_px: &mut Vec<f32>,
    ) {
        if let Some((first, last)) = self.rising[v] {
            // A point is hidden by one to its right, at most as far away as their disparities differ.
            let (least, most) = disparity_px
                .iter()
                .fold((f32::MAX, 0.0_f32), |(a, b), &d| (a.min(d), b.max(d)));
            let reach = (most - least).ceil() as usize + 1;
            let end = (last + 2 + reach).min(disparity_px.len());
            hide_shadow(
                first.saturating_sub(reach),
                &mut disparity_px[..end],
                nearest_px,
            );
        }
        for (u, d) in disparity_px.iter_mut().enumerate() {
            *d = if *d > 0.0 && *d <= u as f32 {
                *d
            } else {
                UNSEEN
            };
        }
    }
}

/// Hides what is behind something else in the right image, from column `start` on; `nearest_px` is scratch space.
fn hide_shadow(start: usize, disparity_px: &mut [f32], nearest_px: &mut Vec<f32>) {
    let column_of = |u: usize, d: f32| {
        Some(u as f32 - d)
            .filter(|column| *column >= 0.0)
            .map(|column| column as usize)
    };
    nearest_px.clear();
    nearest_px.resize(disparity_px.len() + 1, 0.0);
    for (u, &d) in disparity_px.iter().enumerate().skip(start) {
        if let Some(column) = column_of(u, d) {
            // Both neighbours: a surface that faces the right imager more is wider there.
            for nearest in &mut nearest_px[column..][..2] {
                *nearest = nearest.max(d);
            }
        }
    }
    for (u, d) in disparity_px.iter_mut().enumerate().skip(start) {
        if column_of(u, *d).is_some_and(|column| *d + HIDDEN_PX <= nearest_px[column]) {
            *d = UNSEEN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels of a row of disparities that stay visible.
    fn seen(row: &[f32]) -> Vec<bool> {
        let image = InverseDepth {
            width: row.len(),
            height: 1,
            per_m: row.to_vec(),
        };
        let mut edges = Edges::default();
        edges.find(&image, 1.0);
        let mut disparity_px = row.to_vec();
        edges.hide_unseen(0, &mut disparity_px, &mut Vec::new());
        disparity_px.iter().map(|&d| d != UNSEEN).collect()
    }

    #[test]
    fn the_blind_band_is_as_wide_as_the_disparity() {
        let seen = seen(&[10.5; 50]);
        assert_eq!(seen.iter().position(|&s| s), Some(11));
        assert!(seen[11..].iter().all(|&s| s));
    }

    #[test]
    fn a_near_thing_casts_its_shadow_to_the_left() {
        for (left, right) in [(150, 220), (150, 300), (60, 64)] {
            let mut row = vec![14.0; 300];
            row[left..right].fill(52.0);
            let seen = seen(&row);
            for (u, &seen) in seen.iter().enumerate() {
                // In the right image the near thing covers columns from left - 52 up to right - 52.
                let hidden = row[u] == 14.0 && (left..right).contains(&(u + 52 - 14));
                let blind = (u as f32) < row[u];
                // The border is uncertain by a pixel.
                let border = u + 52 - 14 == right;
                assert!(
                    border || seen != (hidden || blind),
                    "column {u} for {left}..{right}"
                );
            }
        }
    }

    #[test]
    fn edges_are_marked_on_both_sides_and_slopes_are_not() {
        let mut image = InverseDepth::empty(9, 8);
        for (index, per_m) in image.per_m.iter_mut().enumerate() {
            *per_m = 1.0 + 0.01 * (index % 9) as f32 + if index / 9 >= 4 { 1.0 } else { 0.0 };
        }
        let mut edges = Edges::default();
        edges.find(&image, 20.0);
        use Nearness::{Edge, Near, Smooth};
        for (v, mark) in [Smooth, Smooth, Near, Edge, Edge, Near, Smooth, Smooth]
            .into_iter()
            .enumerate()
        {
            assert_eq!(edges.row(v), [mark; 9], "row {v}");
        }
    }
}
