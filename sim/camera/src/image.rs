//! Depth images.

/// Depth in millimetres along the optical axis, 0 where nothing was measured (`16UC1`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DepthImage {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major, `width * height` values.
    pub depth_mm: Vec<u16>,
}

impl DepthImage {
    /// An image with no measurement.
    pub fn empty(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            depth_mm: vec![0; width * height],
        }
    }

    /// Depth at column `u` and row `v`, in millimetres.
    ///
    /// # Panics
    /// Outside the image.
    pub fn at(&self, u: usize, v: usize) -> u16 {
        assert!(u < self.width, "column {u} of {}", self.width);
        self.depth_mm[v * self.width + u]
    }

    /// The pixels as little-endian bytes, rows without padding.
    pub fn to_le_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; 2 * self.depth_mm.len()];
        for (two, depth) in bytes.chunks_exact_mut(2).zip(&self.depth_mm) {
            two.copy_from_slice(&depth.to_le_bytes());
        }
        bytes
    }
}

/// Inverse depth 1/z in 1/m, 0 where there is nothing.
///
/// Unlike depth it is affine over a plane's image, and it is proportional to stereo disparity.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseDepth {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row-major, `width * height` values.
    pub per_m: Vec<f32>,
}

impl InverseDepth {
    pub(crate) fn empty(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            per_m: vec![0.0; width * height],
        }
    }

    pub(crate) fn row(&self, v: usize) -> &[f32] {
        &self.per_m[v * self.width..][..self.width]
    }

    /// Depth rounded to millimetres; 0 where there is nothing or it is farther than 65.535 m.
    pub fn to_depth_image(&self) -> DepthImage {
        let depth_mm = self.per_m.iter().map(|&per_m| to_mm(per_m)).collect();
        DepthImage {
            width: self.width,
            height: self.height,
            depth_mm,
        }
    }
}

pub(crate) fn to_mm(per_m: f32) -> u16 {
    let depth_mm = (1000.0 / per_m).round();
    if depth_mm <= f32::from(u16::MAX) {
        depth_mm as u16
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_and_far_are_zero() {
        assert_eq!(
            [0.0, 1.0 / 70.0, 2.0, 1.0 / 0.4004].map(to_mm),
            [0, 0, 500, 400]
        );
    }

    #[test]
    fn bytes_are_little_endian() {
        let image = DepthImage {
            width: 2,
            height: 1,
            depth_mm: vec![0x0102, 3],
        };
        assert_eq!(image.to_le_bytes(), [2, 1, 3, 0]);
        assert_eq!(image.at(1, 0), 3);
    }
}
