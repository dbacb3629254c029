//! The networks that can be trained: the robot's, which is shipped, and the paper's.

pub mod backend;
pub mod export;
pub mod fused;
mod linear;
mod paper;
pub mod product;
mod robot;
pub mod shared_max;
pub mod start;
#[cfg(test)]
mod testing;

use candle_core::{D, Device, Result, Tensor, Var};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

pub use linear::Linear;
pub use paper::{Head, PaperArchitecture, PaperNetwork};
pub use robot::{
    Architecture, NETWORK_VERSION, POINT_INPUTS, PRODUCT_SCALE, RobotNetwork, SQUARE_MIN,
    WAVELENGTHS, wave_numbers,
};

/// Which network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum NetworkKind {
    /// Pools products of the coordinates; for partial views.
    Robot,
    /// As in the paper, Sec. V.
    Paper,
}

/// A network with its weights.
#[derive(Debug, Clone)]
pub enum Network {
    /// See [`RobotNetwork`].
    Robot(RobotNetwork),
    /// See [`PaperNetwork`].
    Paper(PaperNetwork),
}

impl Network {
    /// The robot's network with random weights; the same `random` gives the same weights.
    ///
    /// # Errors
    /// Candle fails.
    pub fn robot(
        architecture: Architecture,
        classes: usize,
        random: &mut Pcg64Mcg,
    ) -> Result<Self> {
        RobotNetwork::new(architecture, classes, random).map(Self::Robot)
    }

    /// The paper's network for clouds of N points, with random weights; the same `random` gives the same weights.
    ///
    /// # Errors
    /// Candle fails.
    pub fn paper(
        architecture: PaperArchitecture,
        point_count: usize,
        classes: usize,
        random: &mut Pcg64Mcg,
    ) -> Result<Self> {
        PaperNetwork::new(architecture, point_count, classes, random).map(Self::Paper)
    }

    /// The same network on a device.
    ///
    /// # Errors
    /// Candle fails.
    pub fn on(&self, device: &Device) -> Result<Self> {
        match self {
            Self::Robot(network) => network.on(device).map(Self::Robot),
            Self::Paper(network) => network.on(device).map(Self::Paper),
        }
    }

    /// The device that holds the weights.
    pub fn device(&self) -> Device {
        let variables = self.variables();
        variables
            .first()
            .map_or(Device::Cpu, |v| v.device().clone())
    }

    /// Logits [B, C] of clouds [B, N, 3], or [B, N, 6] with normals. Their log-sum-exp is the negative energy of Liu et al.
    /// 2020, which measures how much a cloud is like the known classes.
    ///
    /// # Errors
    /// The clouds have another shape.
    pub fn logits(&self, clouds: &Tensor) -> Result<Tensor> {
        match self {
            Self::Robot(network) => network.logits(clouds),
            Self::Paper(network) => network.logits(clouds),
        }
    }

    /// Log-probabilities [B, C] of clouds [B, N, 3 or 6]. The robot's network also learns strangers and gives [B, C + 1]: the
    /// last class is "none of them", whose logit is fixed at 0, so that the negative energy is the log-odds of being known.
    ///
    /// # Errors
    /// The clouds have another shape.
    pub fn forward(&self, clouds: &Tensor) -> Result<Tensor> {
        let mut logits = self.logits(clouds)?;
        if let Self::Robot(_) = self {
            let none = Tensor::zeros((logits.dim(0)?, 1), logits.dtype(), logits.device())?;
            logits = Tensor::cat(&[&logits, &none], 1)?;
        }
        candle_nn::ops::log_softmax(&logits, D::Minus1)
    }

    /// Number of classes.
    pub fn classes(&self) -> usize {
        match self {
            Self::Robot(network) => network.classes,
            Self::Paper(network) => network.classes,
        }
    }

    /// Name and version, stored in each model file.
    pub fn version(&self) -> &'static str {
        match self {
            Self::Robot(_) => NETWORK_VERSION,
            Self::Paper(_) => paper::VERSION,
        }
    }

    /// Number of clouds, of `point_count` points each, to process at once: on a CPU few enough that their tensors stay in a
    /// core's cache, on a GPU many.
    pub fn part_size(&self, point_count: usize) -> usize {
        const LARGEST_TENSOR: usize = 60_000;
        const ON_GPU: usize = 1024;
        if !self.device().is_cpu() {
            return ON_GPU;
        }
        let width = match self {
            Self::Robot(RobotNetwork { architecture, .. }) => {
                architecture.features.max(architecture.transformer_features)
            }
            Self::Paper(network) => network.architecture.features,
        };
        (LARGEST_TENSOR / (point_count * width).max(1)).max(1)
    }

    /// All layers, in a fixed order.
    pub fn layers(&self) -> Vec<&Linear> {
        match self {
            Self::Robot(network) => network.layers().collect(),
            Self::Paper(network) => network.layers().collect(),
        }
    }

    /// All trainable tensors, in a fixed order.
    pub fn variables(&self) -> Vec<Var> {
        let layers = self.layers().into_iter();
        layers
            .flat_map(|layer| [layer.weight.clone(), layer.bias.clone()])
            .collect()
    }

    /// Number of trainable values.
    pub fn parameter_count(&self) -> usize {
        self.variables().iter().map(|v| v.elem_count()).sum()
    }

    /// Copies of all values, for [`Network::restore`].
    ///
    /// # Errors
    /// Candle fails.
    pub fn snapshot(&self) -> Result<Vec<Tensor>> {
        let variables = self.variables();
        variables.iter().map(|v| v.as_tensor().copy()).collect()
    }

    /// Puts values back that [`Network::snapshot`] took from a network of the same architecture.
    ///
    /// # Errors
    /// The shapes differ.
    pub fn restore(&self, snapshot: &[Tensor]) -> Result<()> {
        let variables = self.variables();
        let mut pairs = variables.iter().zip(snapshot);
        pairs.try_for_each(|(variable, values)| variable.set(&values.to_device(variable.device())?))
    }
}
