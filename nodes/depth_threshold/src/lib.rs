//! From a depth image to the points between two depths, in the camera's optical frame (z forward, x right, y down).
//!
//! Three steps, each of which can be switched off: decimation as librealsense does it, removal of flying pixels at
//! depth edges, and the threshold min ≤ z ≤ max. The paper's reference uses 0.25 to 0.70 m.

mod compressed;
mod decimation;
mod image;
mod intrinsics;
mod rvl;

use nalgebra::Point3;
use parameter::{ParameterError, Tunable, check_ranges, tunables};
use serde::{Deserialize, Serialize};

pub use compressed::{CompressedError, Unpacked};
pub use image::{DepthImage, ImageError};
pub use intrinsics::{Calibration, Intrinsics, IntrinsicsError};

use image::Depths;

/// How depth images are thresholded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Nearest depth kept, m.
    pub depth_min_m: f64,
    /// Farthest depth kept, m.
    pub depth_max_m: f64,
    /// Decimation factor: side of the squares of pixels that become one, 1 (none) to 8, as in librealsense.
    pub decimation: u32,
    /// Flying pixels: a pixel is dropped if its depth differs from a neighbour's by more than this, m; 0 drops none. Stereo
    /// depth is smeared at the edge of an object, which gives points between it and the background.
    pub edge_jump_m: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            depth_min_m: *parameter::DEPTH_RANGE_M.start(),
            depth_max_m: *parameter::DEPTH_RANGE_M.end(),
            decimation: 1,
            edge_jump_m: 0.01,
        }
    }
}

impl Parameters {
    /// Parameters that can be changed at run time.
    pub const TUNABLES: &[Tunable<Self>] = tunables! { Self;
        depth_min_m: f64, 0.0..=65.0, "m", "Nearest depth kept";
        depth_max_m: f64, 0.0..=65.0, "m", "Farthest depth kept";
        edge_jump_m: f64, 0.0..=65.0, "m", "Depth step beside a pixel that drops it; 0 drops none";
        decimation: u32, 1..=8, "", "Side of the squares of pixels that become one";
    };

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// Names the first parameter that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for tunable in Self::TUNABLES {
            tunable.check(self)?;
        }
        check_ranges! { self;
            depth_min_m: 0.0..=self.depth_max_m, "m (depth_max_m)";
        }
        Ok(())
    }
}

/// Why an image cannot be thresholded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ThresholdError {
    /// The image is unusable.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The camera_info is unusable.
    #[error(transparent)]
    Intrinsics(#[from] IntrinsicsError),
    /// Image and camera_info have different sizes: they belong to different streams.
    #[error(
        "the depth image is {image_width}×{image_height} but its camera_info is for {info_width}×{info_height}; \
         connect the camera_info that belongs to the image (a decimated stream has one of its own)"
    )]
    SizesDiffer {
        /// Columns of the image.
        image_width: u32,
        /// Rows of the image.
        image_height: u32,
        /// Columns in camera_info.
        info_width: u32,
        /// Rows in camera_info.
        info_height: u32,
    },
}

/// Thresholds images. Reuses its buffers from image to image.
#[derive(Debug, Clone)]
pub struct Thresholder {
    parameters: Parameters,
    full: Depths,
    decimated: Depths,
    rays: Rays,
}

impl Thresholder {
    /// Makes a thresholder with these parameters.
    ///
    /// # Errors
    /// A parameter is out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self {
            parameters,
            full: Depths::default(),
            decimated: Depths::default(),
            rays: Rays::default(),
        })
    }

    /// The parameters in use.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The image's points between the two depths, row by row, m, in the camera's optical frame.
    ///
    /// # Errors
    /// [`ThresholdError`] if the image, its intrinsics or their sizes are unusable.
    pub fn points(
        &mut self,
        image: &DepthImage,
        intrinsics: &Intrinsics,
    ) -> Result<Vec<Point3<f32>>, ThresholdError> {
        check_sizes(image, intrinsics)?;
        image.decode(&mut self.full)?;
        let decimation = self.parameters.decimation;
        let depths = if decimation > 1 {
            decimation::decimate(&self.full, decimation as usize, &mut self.decimated);
            &self.decimated
        } else {
            &self.full
        };
        self.rays.update(&intrinsics.decimated(decimation), depths);
        Ok(keep(depths, &self.rays, &self.parameters))
    }
}

fn check_sizes(image: &DepthImage, intrinsics: &Intrinsics) -> Result<(), ThresholdError> {
    if (image.width, image.height) == (intrinsics.width, intrinsics.height) {
        return Ok(());
    }
    Err(ThresholdError::SizesDiffer {
        image_width: image.width,
        image_height: image.height,
        info_width: intrinsics.width,
        info_height: intrinsics.height,
    })
}

fn keep(depths: &Depths, rays: &Rays, parameters: &Parameters) -> Vec<Point3<f32>> {
    // Compare in the image's unit, so that whole millimetres compare exactly. The margin is far below any camera's
    // resolution.
    let in_units = |length_m: f64| (length_m * f64::from(depths.units_per_m)) as f32;
    let margin_m = 1e-6;
    let (min, max) = (
        in_units(parameters.depth_min_m - margin_m),
        in_units(parameters.depth_max_m + margin_m),
    );
    let jump = match parameters.edge_jump_m {
        0.0 => f32::INFINITY,
        jump_m => in_units(jump_m + margin_m),
    };
    let is_edge = |depth: f32, beside: f32| beside > 0.0 && (beside - depth).abs() > jump;

    let mut points = Vec::with_capacity(depths.values.len() / 8);
    for (y, &ray_y) in rays.y.iter().enumerate() {
        let row = depths.row(y);
        // Pixels at the image's border are their own neighbours, so that they differ from nothing outside.
        let (above, below) = (
            depths.row(y.saturating_sub(1)),
            depths.row((y + 1).min(rays.y.len() - 1)),
        );
        for (x, &depth) in row.iter().enumerate() {
            if !(depth >= min && depth <= max && depth > 0.0) {
                continue;
            }
            let beside = [
                row[x.saturating_sub(1)],
                row[(x + 1).min(row.len() - 1)],
                above[x],
                below[x],
            ];
            if !beside.into_iter().any(|beside| is_edge(depth, beside)) {
                let z = depth / depths.units_per_m;
                points.push(Point3::new(rays.x[x] * z, ray_y * z, z));
            }
        }
    }
    points
}

/// Slopes x / z of the columns and y / z of the rows.
#[derive(Debug, Clone, Default)]
struct Rays {
    of: Option<Intrinsics>,
    x: Vec<f32>,
    y: Vec<f32>,
}

impl Rays {
    fn update(&mut self, intrinsics: &Intrinsics, depths: &Depths) {
        if self.of.as_ref() == Some(intrinsics)
            && (self.x.len(), self.y.len()) == (depths.width, depths.height)
        {
            return;
        }
        let slopes = |count: usize, centre: f64, focal_length: f64| {
            (0..count)
                .map(|pixel| ((pixel as f64 - centre) / focal_length) as f32)
                .collect()
        };
        self.x = slopes(depths.width, intrinsics.cx, intrinsics.fx);
        self.y = slopes(depths.height, intrinsics.cy, intrinsics.fy);
        self.of = Some(intrinsics.clone());
    }
}

#[cfg(test)]
mod tests;
