//! One dense layer.

use candle_core::{DType, Device, Result, Tensor, Var};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::network::fused::bias_relu;
use crate::network::product::product;

/// A fully connected layer: x · weight + bias.
#[derive(Debug, Clone)]
pub struct Linear {
    /// Name, unique in the network.
    pub name: &'static str,
    /// `[inputs, outputs]`
    pub weight: Var,
    /// `[outputs]`
    pub bias: Var,
}

impl Linear {
    /// Random initialisation: uniform weights of variance 2/inputs (He et al. 2015), which keeps the variance of activations
    /// about the same from layer to layer.
    pub(super) fn new(
        name: &'static str,
        inputs: usize,
        outputs: usize,
        random: &mut Pcg64Mcg,
    ) -> Result<Self> {
        let bound = (6.0 / inputs as f32).sqrt();
        let weights = (0..inputs * outputs)
            .map(|_| random.random_range(-bound..bound))
            .collect();
        let weight = Tensor::from_vec(weights, (inputs, outputs), &Device::Cpu)?;
        let bias = Var::zeros(outputs, DType::F32, &Device::Cpu)?;
        Ok(Self {
            name,
            weight: Var::from_tensor(&weight)?,
            bias,
        })
    }

    /// A layer with zero weights: initially its output is `bias`, whatever the input.
    pub(super) fn constant(name: &'static str, inputs: usize, bias: &[f32]) -> Result<Self> {
        let weight = Var::zeros((inputs, bias.len()), DType::F32, &Device::Cpu)?;
        let bias = Var::from_tensor(&Tensor::new(bias, &Device::Cpu)?)?;
        Ok(Self { name, weight, bias })
    }

    /// The same layer on a device.
    pub(super) fn on(&self, device: &Device) -> Result<Self> {
        let var = |var: &Var| Var::from_tensor(&var.as_tensor().to_device(device)?);
        Ok(Self {
            name: self.name,
            weight: var(&self.weight)?,
            bias: var(&self.bias)?,
        })
    }

    pub(super) fn forward(&self, x: &Tensor) -> Result<Tensor> {
        product(x, &self.weight)?.broadcast_add(&self.bias)
    }

    pub(super) fn forward_relu(&self, x: &Tensor) -> Result<Tensor> {
        bias_relu(&product(x, &self.weight)?, &self.bias)
    }

    /// Weight and bias in one tensor, [inputs + 1, outputs], the bias last.
    pub(super) fn packed(&self) -> Result<Tensor> {
        Tensor::cat(&[self.weight.as_tensor(), &self.bias.unsqueeze(0)?], 0)
    }
}
