//! Random tensors and comparisons for tests.
#![allow(clippy::unwrap_used)]

use candle_core::{Device, Shape, Tensor, Var};

/// Normally distributed values.
pub(super) fn random(shape: impl Into<Shape>) -> Var {
    Var::from_tensor(&Tensor::randn(0.0f32, 1.0, shape, &Device::Cpu).unwrap()).unwrap()
}

/// The largest absolute difference between two tensors of one shape.
pub(super) fn largest_difference(a: &Tensor, b: &Tensor) -> f32 {
    assert_eq!(a.dims(), b.dims());
    let difference = (a - b).unwrap().abs().unwrap().flatten_all().unwrap();
    difference.max(0).unwrap().to_scalar().unwrap()
}
