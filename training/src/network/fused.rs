//! Two fused operations of the network, forward and backward.
//!
//! Composed of candle's own operations they take four fifths of a training step on the CPU, mostly for strided sums and
//! temporary buffers. On a GPU they are composed of candle's operations.

use candle_core::{
    CpuStorage, CustomOp1, CustomOp2, D, Layout, Result, Shape, Storage, Tensor, bail,
};

/// max(0, x + bias) for `x` (`[M, F]`) and `bias` (`[F]`).
///
/// # Errors
/// The shapes do not fit.
pub fn bias_relu(x: &Tensor, bias: &Tensor) -> Result<Tensor> {
    if !x.device().is_cpu() {
        return plain_bias_relu(x, bias);
    }
    x.contiguous()?.apply_op2(bias, BiasRelu)
}

/// Maximum and mean over the points: `[B, N, F]` to `[B, 2 F]`, all maxima first.
///
/// # Errors
/// The shape has other than three dimensions.
pub fn pool(features: &Tensor) -> Result<Tensor> {
    if !features.device().is_cpu() {
        return plain_pool(features);
    }
    features.contiguous()?.apply_op1(Pool)
}

fn plain_bias_relu(x: &Tensor, bias: &Tensor) -> Result<Tensor> {
    x.broadcast_add(bias)?.relu()
}

fn plain_pool(features: &Tensor) -> Result<Tensor> {
    Tensor::cat(&[features.max(1)?, features.mean(1)?], D::Minus1)
}

struct BiasRelu;

impl CustomOp2 for BiasRelu {
    fn name(&self) -> &'static str {
        "bias-relu"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_l: &Layout,
        bias: &CpuStorage,
        b_l: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let (x, bias) = (values(x, x_l)?, values(bias, b_l)?);
        let mut result = Vec::with_capacity(x.len());
        for row in x.chunks_exact(bias.len()) {
            result.extend(row.iter().zip(bias).map(|(x, b)| relu(x + b)));
        }
        Ok((CpuStorage::F32(result), x_l.shape().clone()))
    }

    fn bwd(
        &self,
        x: &Tensor,
        bias: &Tensor,
        result: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let mut bias_grad = vec![0.0; bias.elem_count()];
        let x_grad = with_values(result, |result| {
            with_values(grad, |grad| {
                let mut x_grad = Vec::with_capacity(grad.len());
                let width = bias_grad.len();
                for (result, grad) in result.chunks_exact(width).zip(grad.chunks_exact(width)) {
                    for ((&r, &g), sum) in result.iter().zip(grad).zip(&mut bias_grad) {
                        let passed = if r > 0.0 { g } else { 0.0 };
                        *sum += passed;
                        x_grad.push(passed);
                    }
                }
                Ok(x_grad)
            })
        })?;
        let x_grad = Tensor::from_vec(x_grad, x.shape(), x.device())?;
        let bias_grad = Tensor::from_vec(bias_grad, bias.shape(), x.device())?;
        Ok((Some(x_grad), Some(bias_grad)))
    }
}

/// Rectified linear unit. Unlike `f32::max` it keeps a NaN, so that diverging training is noticed.
pub(crate) fn relu(value: f32) -> f32 {
    if value < 0.0 { 0.0 } else { value }
}

struct Pool;

impl CustomOp1 for Pool {
    fn name(&self) -> &'static str {
        "pool"
    }

    fn cpu_fwd(&self, features: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (batch, count, width) = layout.shape().dims3()?;
        let features = values(features, layout)?;
        let mut result = vec![0.0; batch * 2 * width];
        for (cloud, pooled) in features
            .chunks_exact(count * width)
            .zip(result.chunks_exact_mut(2 * width))
        {
            let (maxima, means) = pooled.split_at_mut(width);
            maxima.fill(f32::NEG_INFINITY);
            for point in cloud.chunks_exact(width) {
                for ((&value, max), mean) in
                    point.iter().zip(maxima.iter_mut()).zip(means.iter_mut())
                {
                    *max = max.max(value);
                    *mean += value;
                }
            }
            means.iter_mut().for_each(|mean| *mean /= count as f32);
        }
        Ok((CpuStorage::F32(result), Shape::from((batch, 2 * width))))
    }

    fn bwd(&self, features: &Tensor, result: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let (_, count, width) = features.dims3()?;
        let features_grad = with_values(features, |features| {
            with_values(result, |result| {
                with_values(grad, |grad| {
                    Ok(pool_backward(features, result, grad, [count, width]))
                })
            })
        })?;
        Tensor::from_vec(features_grad, features.shape(), features.device()).map(Some)
    }
}

fn pool_backward(
    features: &[f32],
    result: &[f32],
    grad: &[f32],
    [count, width]: [usize; 2],
) -> Vec<f32> {
    let mut features_grad = Vec::with_capacity(features.len());
    let clouds = features.chunks_exact(count * width);
    for ((cloud, result), grad) in clouds
        .zip(result.chunks_exact(2 * width))
        .zip(grad.chunks_exact(2 * width))
    {
        // A maximum reached by several points passes its gradient on to the first of them only.
        let mut left = grad[..width].to_vec();
        let shares: Vec<f32> = grad[width..]
            .iter()
            .map(|grad| grad / count as f32)
            .collect();
        for point in cloud.chunks_exact(width) {
            for (((&value, &max), left), share) in point
                .iter()
                .zip(&result[..width])
                .zip(&mut left)
                .zip(&shares)
            {
                let is_max = value == max;
                features_grad.push(if is_max { share + *left } else { *share });
                *left = if is_max { 0.0 } else { *left };
            }
        }
    }
    features_grad
}

pub(crate) fn values<'a>(storage: &'a CpuStorage, layout: &Layout) -> Result<&'a [f32]> {
    match (storage, layout.contiguous_offsets()) {
        (CpuStorage::F32(values), Some((start, end))) => Ok(&values[start..end]),
        _ => bail!("only contiguous float32 tensors are pooled"),
    }
}

pub(crate) fn with_values<T>(
    tensor: &Tensor,
    use_values: impl FnOnce(&[f32]) -> Result<T>,
) -> Result<T> {
    let tensor = tensor.contiguous()?;
    let (storage, layout) = tensor.storage_and_layout();
    match &*storage {
        Storage::Cpu(storage) => use_values(values(storage, layout)?),
        _ => bail!("only tensors on the CPU are pooled"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use candle_core::{Device, Var};

    use super::*;

    fn random(shape: impl Into<Shape>) -> Var {
        Var::from_tensor(&Tensor::randn(0.0f32, 1.0, shape, &Device::Cpu).unwrap()).unwrap()
    }

    fn assert_close(a: &Tensor, b: &Tensor) {
        assert_eq!(a.dims(), b.dims());
        let difference = (a - b)
            .unwrap()
            .abs()
            .unwrap()
            .flatten_all()
            .unwrap()
            .max(0)
            .unwrap();
        assert!(difference.to_scalar::<f32>().unwrap() < 1e-5, "{a} {b}");
    }

    /// Compares values and gradients of two expressions in the same variables, under a random weighting.
    fn assert_same(variables: &[&Var], fused: &Tensor, plain: &Tensor) {
        assert_close(fused, plain);
        let weights = random(fused.shape());
        let gradients = |result: &Tensor| {
            (result * weights.as_tensor())
                .unwrap()
                .sum_all()
                .unwrap()
                .backward()
                .unwrap()
        };
        let (fused, plain) = (gradients(fused), gradients(plain));
        for variable in variables {
            assert_close(fused.get(variable).unwrap(), plain.get(variable).unwrap());
        }
    }

    #[test]
    fn bias_relu_is_what_candle_makes_of_add_and_relu() {
        let (x, bias) = (random((7, 5)), random(5));
        let plain = plain_bias_relu(&x, &bias).unwrap();
        assert_same(&[&x, &bias], &bias_relu(&x, &bias).unwrap(), &plain);
    }

    #[test]
    fn pool_is_what_candle_makes_of_max_and_mean() {
        let x = random((3, 6, 4));
        let plain = plain_pool(&x).unwrap();
        assert_same(&[&x], &pool(&x).unwrap(), &plain);
    }

    #[test]
    fn a_shared_maximum_passes_its_gradient_once() {
        let x = Var::from_tensor(
            &Tensor::zeros((1, 3, 1), candle_core::DType::F32, &Device::Cpu).unwrap(),
        )
        .unwrap();
        let gradients = pool(&x).unwrap().sum_all().unwrap().backward().unwrap();
        let gradient = gradients
            .get(&x)
            .unwrap()
            .flatten_all()
            .unwrap()
            .to_vec1::<f32>()
            .unwrap();
        let third = 1.0 / 3.0;
        assert_eq!(gradient, [1.0 + third, third, third]);
    }
}
