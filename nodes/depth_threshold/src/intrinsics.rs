//! What a camera_info message says about the lens.

/// A camera without distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct Intrinsics {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Column of the optical axis, pixels; 0 is the middle of the first column.
    pub cx: f64,
    /// Row of the optical axis, pixels.
    pub cy: f64,
    /// Columns of the image.
    pub width: u32,
    /// Rows of the image.
    pub height: u32,
}

/// Why a camera_info cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IntrinsicsError {
    /// Uncalibrated cameras publish zeros (REP 104).
    #[error(
        "camera_info has focal lengths fx = {fx}, fy = {fy}; both must be positive: is the camera calibrated?"
    )]
    FocalLength {
        /// `K[0]`.
        fx: f64,
        /// `K[4]`.
        fy: f64,
    },
    /// No camera looks beside its own image.
    #[error(
        "camera_info has its optical axis at ({cx}, {cy}), outside its image of {width}×{height}"
    )]
    Centre {
        /// `K[2]`.
        cx: f64,
        /// `K[5]`.
        cy: f64,
        /// Columns of the image.
        width: u32,
        /// Rows of the image.
        height: u32,
    },
    /// Nothing else has a meaning here.
    #[error(
        "camera_info's K {k:?} is not [fx 0 cx 0 fy cy 0 0 1]; take that of the rectified image"
    )]
    Form {
        /// Row by row.
        k: [f64; 9],
    },
}

impl Intrinsics {
    /// Checks the matrix `k` (row by row, as in camera_info) of an image of this size.
    pub fn from_k(k: &[f64; 9], width: u32, height: u32) -> Result<Self, IntrinsicsError> {
        let &[fx, skew, cx, zero_a, fy, cy, zero_b, zero_c, one] = k;
        if !(fx.is_finite() && fy.is_finite() && fx > 0.0 && fy > 0.0) {
            return Err(IntrinsicsError::FocalLength { fx, fy });
        }
        if [skew, zero_a, zero_b, zero_c] != [0.0; 4] || one != 1.0 {
            return Err(IntrinsicsError::Form { k: *k });
        }
        let inside =
            (0.0..=f64::from(width)).contains(&cx) && (0.0..=f64::from(height)).contains(&cy);
        if !inside {
            return Err(IntrinsicsError::Centre {
                cx,
                cy,
                width,
                height,
            });
        }
        Ok(Self {
            fx,
            fy,
            cx,
            cy,
            width,
            height,
        })
    }

    /// Those of an image decimated by `factor`: librealsense divides all four, without a shift by half a pixel.
    pub fn decimated(&self, factor: u32) -> Self {
        let divided = |value: f64| value / f64::from(factor);
        Self {
            fx: divided(self.fx),
            fy: divided(self.fy),
            cx: divided(self.cx),
            cy: divided(self.cy),
            ..*self
        }
    }
}
