//! The paper's network (Sec. V, Fig. 6): a spatial transformer turns the points into a frame that it predicts, two layers
//! shared by all points compute F features, and one dense layer classifies.
//!
//! Before the dense layer the features are pooled over the points (the largest of each): the order of the points then
//! does not matter, and the number of weights does not depend on N (Fig. 8b). Or they are flattened, as the text says.

use candle_core::{Device, Result, Tensor};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::linear::Linear;
use crate::network::product::turned;
use crate::network::shared_max::shared_max;

/// Name and version of this network, stored in each model file.
pub(super) const VERSION: &str = "paper-spatial-transformer-1";

/// Design choices of the paper's network (Sec. VI-B).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PaperArchitecture {
    /// F, features of a point.
    pub features: usize,
    /// Whether points come with normals (N×6 instead of N×3).
    pub normals: bool,
    /// What the dense layer sees.
    #[serde(skip_serializing_if = "Head::is_pool")]
    pub head: Head,
}

/// What the dense layer of the paper's network sees of the points' features.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Head {
    /// The largest of each feature: F values.
    #[default]
    Pool,
    /// All features of all points, one point after the other: N × F values.
    Flatten,
}

impl Head {
    fn is_pool(&self) -> bool {
        *self == Self::Pool
    }
}

impl Default for PaperArchitecture {
    fn default() -> Self {
        Self {
            features: 80,
            normals: false,
            head: Head::Pool,
        }
    }
}

impl PaperArchitecture {
    /// Values of a point.
    pub fn columns(&self) -> usize {
        if self.normals { 6 } else { 3 }
    }
}

/// The network's layers, in the order of `Paper::layers`.
#[derive(Debug, Clone)]
pub struct PaperNetwork {
    /// Design choices.
    pub architecture: PaperArchitecture,
    /// Number of classes.
    pub classes: usize,
    pub(crate) transform_points: [Linear; 2],
    pub(crate) transform_head: Linear,
    pub(crate) points: [Linear; 2],
    pub(crate) head: Linear,
}

impl PaperNetwork {
    pub(super) fn new(
        architecture: PaperArchitecture,
        point_count: usize,
        classes: usize,
        random: &mut Pcg64Mcg,
    ) -> Result<Self> {
        let (columns, features) = (architecture.columns(), architecture.features);
        let seen = match architecture.head {
            Head::Pool => features,
            Head::Flatten => point_count * features,
        };
        let mut shared = |names: [&'static str; 2]| -> Result<[Linear; 2]> {
            Ok([
                Linear::new(names[0], columns, features, random)?,
                Linear::new(names[1], features, features, random)?,
            ])
        };
        Ok(Self {
            architecture,
            classes,
            transform_points: shared(["transform_point_1", "transform_point_2"])?,
            // The transformer is initialised to the identity.
            transform_head: Linear::constant(
                "transform_head",
                features,
                &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            )?,
            points: shared(["point_1", "point_2"])?,
            head: Linear::new("head", seen, classes, random)?,
        })
    }

    /// Logits [B, C] of clouds [B, N, 3 or 6].
    pub(super) fn logits(&self, clouds: &Tensor) -> Result<Tensor> {
        let batch = clouds.dim(0)?;
        let summary = pooled_features(&self.transform_points, clouds)?;
        let turn = self.transform_head.forward(&summary)?;
        let turn = turn.reshape((batch, 3, 3))?;
        let placed = turned(&clouds.narrow(2, 0, 3)?, &turn)?;
        let placed = match self.architecture.normals {
            true => Tensor::cat(&[placed, clouds.narrow(2, 3, 3)?], 2)?,
            false => placed,
        };
        let seen = match self.architecture.head {
            Head::Pool => pooled_features(&self.points, &placed)?,
            Head::Flatten => {
                let [first, second] = &self.points;
                let (_, count, columns) = placed.dims3()?;
                let points = placed.reshape((batch * count, columns))?;
                let features = second.forward_relu(&first.forward_relu(&points)?)?;
                features.reshape((batch, ()))?
            }
        };
        self.head.forward(&seen)
    }

    pub(super) fn on(&self, device: &Device) -> Result<Self> {
        let pair =
            |[a, b]: &[Linear; 2]| -> Result<[Linear; 2]> { Ok([a.on(device)?, b.on(device)?]) };
        Ok(Self {
            transform_points: pair(&self.transform_points)?,
            transform_head: self.transform_head.on(device)?,
            points: pair(&self.points)?,
            head: self.head.on(device)?,
            ..*self
        })
    }

    pub(super) fn layers(&self) -> impl Iterator<Item = &Linear> {
        self.transform_points
            .iter()
            .chain([&self.transform_head])
            .chain(&self.points)
            .chain([&self.head])
    }
}

/// The largest of each feature over the points: [B, N, C] to [B, F].
fn pooled_features(layers: &[Linear; 2], clouds: &Tensor) -> Result<Tensor> {
    shared_max(clouds, &layers[0].packed()?, &layers[1].packed()?)
}
