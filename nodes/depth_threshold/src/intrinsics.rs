//! Intrinsics from camera_info messages.

/// The relevant fields of a sensor_msgs/CameraInfo, borrowed (REP 104 and the message's own comments).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration<'a> {
    /// Columns of the image that was calibrated.
    pub width: u32,
    /// Rows of that image.
    pub height: u32,
    /// Distortion of the image before rectification; empty or zeros for none.
    pub d: &'a [f64],
    /// K: camera matrix of the image before rectification, 3 × 3, row-major.
    pub k: &'a [f64; 9],
    /// P: projection matrix of the rectified image, 3 × 4, row-major; zeros if unknown.
    pub p: &'a [f64; 12],
    /// Number of columns and rows of the sensor that are combined into one; 0 means 1.
    pub binning: [u32; 2],
    /// Region of interest before binning: first column, first row, columns, rows; zeros for the whole image.
    pub region: [u32; 4],
}

/// A pinhole camera without distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct Intrinsics {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Column of the principal point, pixels; 0 is the centre of the first column.
    pub cx: f64,
    /// Row of the principal point, pixels.
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
        /// Along x, pixels.
        fx: f64,
        /// Along y, pixels.
        fy: f64,
    },
    /// The principal point lies outside the image.
    #[error(
        "camera_info has its optical axis at ({cx}, {cy}), outside its image of {width}×{height}"
    )]
    Centre {
        /// Its column.
        cx: f64,
        /// Its row.
        cy: f64,
        /// Columns of the image.
        width: u32,
        /// Rows of the image.
        height: u32,
    },
    /// The matrix is not that of a rectified pinhole camera.
    #[error(
        "camera_info's {name} {matrix:?} is not [fx 0 cx, 0 fy cy, 0 0 1]; take that of the rectified image"
    )]
    Form {
        /// K or P.
        name: &'static str,
        /// Row by row.
        matrix: Vec<f64>,
    },
    /// The image is distorted: its pixels are not where the camera matrix projects.
    #[error(
        "camera_info has distortion {d:?}, and the image on {topic} is not rectified; connect a rectified depth image, like \
         camera/depth/image_rect_raw, or rectify it (rosrun image_proc image_proc)"
    )]
    Distorted {
        /// The message's distortion coefficients.
        d: Vec<f64>,
        /// Topic of the image.
        topic: String,
    },
    /// The image is rectified, but P, which describes it, is missing.
    #[error(
        "camera_info has distortion {d:?} and no P, which describes the rectified image on {topic}; publish it, or calibrate \
         the camera (rosrun camera_calibration cameracalibrator.py)"
    )]
    NoProjection {
        /// The message's distortion coefficients.
        d: Vec<f64>,
        /// Topic of the image.
        topic: String,
    },
}

impl Calibration<'_> {
    /// Intrinsics of the images on `topic`. Its name tells whether they are rectified (`image_rect`, `image_rect_raw`): P
    /// describes those, K and D the others.
    ///
    /// # Errors
    /// [`IntrinsicsError`] if the matrix is unusable, or the image is distorted.
    pub fn intrinsics(&self, topic: &str) -> Result<Intrinsics, IntrinsicsError> {
        let mut words = topic.rsplit('/').next().unwrap_or_default().split('_');
        let is_rectified = words.any(|word| ["rect", "rectified"].contains(&word));
        let is_distorted = self.d.iter().any(|&part| part != 0.0);
        let (d, topic) = (self.d.to_vec(), topic.to_owned());
        let [p0, p1, p2, _, p4, p5, p6, _, p8, p9, p10, _] = *self.p;
        if is_distorted && !is_rectified {
            Err(IntrinsicsError::Distorted { d, topic })
        } else if is_rectified && p0 != 0.0 {
            self.of_matrix("P", [p0, p1, p2, p4, p5, p6, p8, p9, p10])
        } else if is_distorted {
            Err(IntrinsicsError::NoProjection { d, topic })
        } else {
            self.of_matrix("K", *self.k)
        }
    }

    fn of_matrix(
        &self,
        name: &'static str,
        matrix: [f64; 9],
    ) -> Result<Intrinsics, IntrinsicsError> {
        let [fx, skew, cx, zero_a, fy, cy, zero_b, zero_c, one] = matrix;
        if !(fx.is_finite() && fy.is_finite() && fx > 0.0 && fy > 0.0) {
            return Err(IntrinsicsError::FocalLength { fx, fy });
        }
        if [skew, zero_a, zero_b, zero_c] != [0.0; 4] || one != 1.0 {
            let matrix = matrix.to_vec();
            return Err(IntrinsicsError::Form { name, matrix });
        }
        let (width, height) = (self.width, self.height);
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
        let whole = Intrinsics {
            fx,
            fy,
            cx,
            cy,
            width,
            height,
        };
        Ok(whole.shown(self.region, self.binning))
    }
}

impl Intrinsics {
    /// Intrinsics of a region of the image after binning, as `image_geometry::PinholeCameraModel` computes them.
    fn shown(self, region: [u32; 4], binning: [u32; 2]) -> Self {
        let [x, y, width, height] = match region {
            [_, _, 0, _] | [_, _, _, 0] => [0, 0, self.width, self.height],
            region => region,
        };
        let [bin_x, bin_y] = binning.map(|bin| bin.max(1));
        let along = |value: f64, bin: u32| value / f64::from(bin);
        Self {
            fx: along(self.fx, bin_x),
            fy: along(self.fy, bin_y),
            cx: along(self.cx - f64::from(x), bin_x),
            cy: along(self.cy - f64::from(y), bin_y),
            width: width / bin_x,
            height: height / bin_y,
        }
    }

    /// Intrinsics of an image decimated by `factor`. Like librealsense it divides all four numbers, without a shift by half
    /// a pixel.
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
