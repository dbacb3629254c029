//! The robot's network, after the paper's (Sec. V, Fig. 6): a spatial transformer turns the points into a frame that it
//! predicts, two layers shared by all points compute features, and a dense head classifies.
//!
//! Differences from the figure: features are pooled over the points (maximum and mean) before the dense layer instead
//! of being flattened, so that the order of the points does not matter and the weights stay within 100 KB; and the
//! second pair of layers sees products of the coordinates beside them.

use candle_core::{Device, Result, Tensor};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::linear::Linear;
use crate::network::fused::pool;
use crate::network::product::turned;

/// Name and version of this network, stored in each model file.
pub const NETWORK_VERSION: &str = "spatial-transformer-pooled-waves-1";

/// Values of a point that the shared layers see.
pub const POINT_INPUTS: usize = 12 + 4 * WAVELENGTHS.len();
/// Fourier features (Tancik et al. 2020): wavelengths, in scaled units of 40 mm, of the sines and cosines of a point's
/// distances from the origin and from the up axis. They make differences of a millimetre in radius as easy to learn as a
/// centimetre.
pub const WAVELENGTHS: [f32; 3] = [0.4, 0.8, 1.6];
/// Factor of the coordinates before they are multiplied, so that their squares are also about 1 for an object.
pub const PRODUCT_SCALE: f64 = 2.5;

/// Widths of the layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Architecture {
    /// Features of a point in the spatial transformer.
    pub transformer_features: usize,
    /// Features of a point before pooling (the paper's F).
    pub features: usize,
    /// Width of the head's hidden layer.
    pub hidden: usize,
}

impl Default for Architecture {
    fn default() -> Self {
        Self {
            transformer_features: 48,
            features: 96,
            hidden: 48,
        }
    }
}

/// The network's layers, in the order of `RobotNetwork::layers`.
#[derive(Debug, Clone)]
pub struct RobotNetwork {
    /// Widths of the layers.
    pub architecture: Architecture,
    /// Number of classes.
    pub classes: usize,
    pub(crate) transform_points: [Linear; 2],
    pub(crate) transform_head: [Linear; 2],
    pub(crate) transform_shift: Linear,
    pub(crate) points: [Linear; 2],
    pub(crate) head: [Linear; 2],
}

impl RobotNetwork {
    pub(super) fn new(
        architecture: Architecture,
        classes: usize,
        random: &mut Pcg64Mcg,
    ) -> Result<Self> {
        let Architecture {
            transformer_features,
            features,
            hidden,
        } = architecture;
        let narrow = transformer_features / 2;
        Ok(Self {
            architecture,
            classes,
            transform_points: [
                Linear::new("transform_point_1", POINT_INPUTS, narrow, random)?,
                Linear::new("transform_point_2", narrow, transformer_features, random)?,
            ],
            transform_head: [
                Linear::new("transform_head_1", 2 * transformer_features, narrow, random)?,
                // The transformer is initialised to the identity.
                Linear::constant(
                    "transform_head_2",
                    narrow,
                    &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                )?,
            ],
            transform_shift: Linear::constant("transform_shift", narrow, &[0.0; 3])?,
            points: [
                Linear::new("point_1", POINT_INPUTS, features / 2, random)?,
                Linear::new("point_2", features / 2, features, random)?,
            ],
            head: [
                Linear::new("head_1", 2 * features, hidden, random)?,
                Linear::new("head_2", hidden, classes, random)?,
            ],
        })
    }

    /// Logits [B, C] of clouds [B, N, 3].
    pub(super) fn logits(&self, clouds: &Tensor) -> Result<Tensor> {
        let batch = clouds.dim(0)?;
        let summary = pooled_features(&self.transform_points, &with_products(clouds)?)?;
        let hidden = self.transform_head[0].forward_relu(&summary)?;
        let turn = self.transform_head[1]
            .forward(&hidden)?
            .reshape((batch, 3, 3))?;
        let shift = self
            .transform_shift
            .forward(&hidden)?
            .reshape((batch, 1, 3))?;
        let placed = turned(clouds, &turn)?.broadcast_add(&shift)?;
        let summary = pooled_features(&self.points, &with_products(&placed)?)?;
        self.head[1].forward(&self.head[0].forward_relu(&summary)?)
    }

    pub(super) fn on(&self, device: &Device) -> Result<Self> {
        let pair =
            |[a, b]: &[Linear; 2]| -> Result<[Linear; 2]> { Ok([a.on(device)?, b.on(device)?]) };
        Ok(Self {
            transform_points: pair(&self.transform_points)?,
            transform_head: pair(&self.transform_head)?,
            transform_shift: self.transform_shift.on(device)?,
            points: pair(&self.points)?,
            head: pair(&self.head)?,
            ..*self
        })
    }

    pub(super) fn layers(&self) -> impl Iterator<Item = &Linear> {
        self.transform_points
            .iter()
            .chain(&self.transform_head)
            .chain([&self.transform_shift])
            .chain(&self.points)
            .chain(&self.head)
    }
}

/// Features of each point, pooled over the points: [B, N, 3] to [B, 2 F].
fn pooled_features(layers: &[Linear; 2], clouds: &Tensor) -> Result<Tensor> {
    let (batch, count, columns) = clouds.dims3()?;
    let features = layers[0].forward_relu(&clouds.reshape((batch * count, columns))?)?;
    let features = layers[1].forward_relu(&features)?;
    pool(&features.reshape((batch, count, ()))?)
}

/// A point's coordinates, their squares and products, the coordinates times the squared distance from the origin, and the
/// Fourier features of its distances: [B, N, 3] to [B, N, POINT_INPUTS]. The mean of these determines a ball's radius; to
/// learn it from coordinates alone takes more features than a model of 100 KB has.
fn with_products(points: &Tensor) -> Result<Tensor> {
    let points = (points * PRODUCT_SCALE)?;
    let squares = points.sqr()?;
    let rolled = Tensor::cat(&[points.narrow(2, 1, 2)?, points.narrow(2, 0, 1)?], 2)?;
    let squared_norm = squares.sum_keepdim(2)?;
    let cubes = points.broadcast_mul(&squared_norm)?;
    let across = squares.narrow(2, 0, 2)?.sum_keepdim(2)?;
    let distances = (Tensor::cat(&[squared_norm, across], 2)? + SQUARE_MIN)?.sqrt()?;
    let (sines, cosines) = waves(&distances)?;
    Tensor::cat(
        &[
            &points,
            &squares,
            &(&points * rolled)?,
            &cubes,
            &sines,
            &cosines,
        ],
        2,
    )
}

/// Added to squared distances, so that the gradient of their roots is finite at 0.
pub const SQUARE_MIN: f64 = 1e-4;

/// Phases of [.., 2] distances, [2, 2 W]: each distance in each wavelength.
pub fn wave_numbers() -> [f32; 4 * WAVELENGTHS.len()] {
    let mut numbers = [0.0; 4 * WAVELENGTHS.len()];
    for (index, wavelength) in WAVELENGTHS.iter().enumerate() {
        let number = std::f32::consts::TAU / wavelength;
        numbers[index] = number;
        numbers[3 * WAVELENGTHS.len() + index] = number;
    }
    numbers
}

fn waves(distances: &Tensor) -> Result<(Tensor, Tensor)> {
    let (batch, count, _) = distances.dims3()?;
    let numbers = wave_numbers();
    let numbers = Tensor::from_slice(&numbers, (2, numbers.len() / 2), distances.device())?;
    let phases = distances.reshape((batch * count, 2))?.matmul(&numbers)?;
    let phases = phases.reshape((batch, count, ()))?;
    Ok((phases.sin()?, phases.cos()?))
}
