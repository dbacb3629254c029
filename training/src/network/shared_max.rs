//! Two ReLU layers shared by all points and the max pooling of their features, as one fused operation.
//!
//! Only the point with a feature's maximum gets a gradient, so the backward pass visits F points of each cloud instead of
//! N × F values and is much cheaper than the forward pass. On a GPU it is composed of candle's own operations.

use std::sync::{Mutex, PoisonError};

use candle_core::{CpuStorage, CustomOp3, D, Layout, Result, Shape, Tensor, bail};

use crate::network::fused::{relu, values, with_values};
use crate::network::product::multiply;

/// max over the points of relu(relu(x · w₁ + b₁) · w₂ + b₂): `x` [B, N, C], `first` [C + 1, H], `second` [H + 1, F], each
/// with its bias in the last row; result [B, F].
///
/// # Errors
/// The shapes do not fit.
pub fn shared_max(x: &Tensor, first: &Tensor, second: &Tensor) -> Result<Tensor> {
    let (points, first, second) = (x.contiguous()?, first.contiguous()?, second.contiguous()?);
    if !points.device().is_cpu() {
        return plain(&points, &first, &second);
    }
    points.apply_op3(&first, &second, SharedMax::default())
}

fn plain(points: &Tensor, first: &Tensor, second: &Tensor) -> Result<Tensor> {
    let (batch, count, _) = points.dims3()?;
    let ones = Tensor::ones((batch, count, 1), points.dtype(), points.device())?;
    let layer = |x: &Tensor, layer: &Tensor| -> Result<Tensor> {
        Tensor::cat(&[x, &ones], D::Minus1)?
            .broadcast_matmul(layer)?
            .relu()
    };
    layer(&layer(points, first)?, second)?.max(1)
}

/// Points that are multiplied at once: their results stay in the cache until the maxima are taken.
const ROWS_AT_ONCE: usize = 64;

#[derive(Default)]
struct SharedMax {
    /// Intermediate results of the forward pass for the backward pass.
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    /// [B, N, H] after the first layer.
    hidden: Vec<f32>,
    /// [B, F] which point has the largest value.
    winners: Vec<u32>,
}

/// Sizes, in the order [B, N, C, H, F].
fn sizes(x: &Shape, first: &Shape, second: &Shape) -> Result<[usize; 5]> {
    let (batch, count, columns) = x.dims3()?;
    let ((inputs, hidden), (hiddens, features)) = (first.dims2()?, second.dims2()?);
    if inputs != columns + 1 || hiddens != hidden + 1 || count == 0 {
        bail!("points {x:?} do not fit layers {first:?} and {second:?}");
    }
    Ok([batch, count, columns, hidden, features])
}

impl CustomOp3 for SharedMax {
    fn name(&self) -> &'static str {
        "shared-max"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_l: &Layout,
        first: &CpuStorage,
        first_l: &Layout,
        second: &CpuStorage,
        second_l: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let sizes = sizes(x_l.shape(), first_l.shape(), second_l.shape())?;
        let [batch, count, _, width, features] = sizes;
        let hidden = hidden_layer(values(x, x_l)?, values(first, first_l)?, sizes);
        let (weights, biases) = values(second, second_l)?.split_at(width * features);
        let mut maxima = vec![f32::NEG_INFINITY; batch * features];
        let mut winners = vec![0; batch * features];
        let of_clouds = maxima.chunks_exact_mut(features);
        for (cloud, (maxima, winners)) in of_clouds
            .zip(winners.chunks_exact_mut(features))
            .enumerate()
        {
            let of_cloud = &hidden[cloud * count * width..(cloud + 1) * count * width];
            for (part, rows) in of_cloud.chunks(ROWS_AT_ONCE * width).enumerate() {
                let outputs = multiply(rows, weights, [rows.len() / width, width, features]);
                raise(maxima, winners, outputs.as_slice(), part * ROWS_AT_ONCE);
            }
            maxima
                .iter_mut()
                .zip(biases)
                .for_each(|(best, bias)| *best = relu(*best + bias));
        }
        *self.kept.lock().unwrap_or_else(PoisonError::into_inner) = Kept { hidden, winners };
        Ok((CpuStorage::F32(maxima), Shape::from((batch, features))))
    }

    fn bwd(
        &self,
        x: &Tensor,
        first: &Tensor,
        second: &Tensor,
        result: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let sizes = sizes(x.shape(), first.shape(), second.shape())?;
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        // ReLU passes no gradient where its output is 0.
        let grad = (result.gt(0.0)?.to_dtype(grad.dtype())? * grad)?;
        // Rows of the transposed weights are what one feature needs.
        let second_t = second.t()?;
        let [x_grad, first_grad, second_t_grad] = with_values(x, |x| {
            with_values(first, |first| {
                with_values(&second_t, |second_t| {
                    with_values(&grad, |grad| {
                        Ok(backward([x, first, second_t, grad], &kept, sizes))
                    })
                })
            })
        })?;
        let tensor = |values, like: &Tensor| Tensor::from_vec(values, like.shape(), x.device());
        let second_grad = tensor(second_t_grad, &second_t)?.t()?.contiguous()?;
        Ok((
            Some(tensor(x_grad, x)?),
            Some(tensor(first_grad, first)?),
            Some(second_grad),
        ))
    }
}

/// relu(x · w + b) of each point: [B N, C] to [B N, H].
fn hidden_layer(x: &[f32], layer: &[f32], [.., columns, width, _]: [usize; 5]) -> Vec<f32> {
    let mut hidden = Vec::with_capacity(x.len() / columns * width);
    let (weights, biases) = layer.split_at(columns * width);
    for point in x.chunks_exact(columns) {
        let start = hidden.len();
        hidden.extend_from_slice(biases);
        let row = &mut hidden[start..];
        for (&value, weights) in point.iter().zip(weights.chunks_exact(width)) {
            add_scaled(row, value, weights);
        }
        row.iter_mut().for_each(|value| *value = relu(*value));
    }
    hidden
}

/// Updates each feature's maximum, and the point that has it, by the outputs of points numbered from `start`.
fn raise(maxima: &mut [f32], winners: &mut [u32], outputs: &[f32], start: usize) {
    for (index, point) in outputs.chunks_exact(maxima.len()).enumerate() {
        let best = maxima.iter_mut().zip(winners.iter_mut());
        for (&value, (best, winner)) in point.iter().zip(best) {
            // Written so that a NaN is kept and diverging training is noticed.
            let stays = value <= *best || best.is_nan();
            *best = if stays { *best } else { value };
            *winner = if stays {
                *winner
            } else {
                (start + index) as u32
            };
        }
    }
}

/// Gradients of the points, the first layer and the second layer, transposed.
fn backward(
    [x, first, second_t, grad]: [&[f32]; 4],
    kept: &Kept,
    [batch, count, columns, width, features]: [usize; 5],
) -> [Vec<f32>; 3] {
    let mut x_grad = vec![0.0; x.len()];
    let mut first_grad = vec![0.0; first.len()];
    let mut second_t_grad = vec![0.0; second_t.len()];
    let mut hidden_grad = vec![0.0; count * width];
    let mut is_winner = vec![false; count];
    for cloud in 0..batch {
        hidden_grad.fill(0.0);
        is_winner.fill(false);
        let of_cloud = cloud * features..(cloud + 1) * features;
        let grads = grad[of_cloud.clone()].iter().zip(&kept.winners[of_cloud]);
        let rows = second_t.chunks_exact(width + 1);
        let rows = rows.zip(second_t_grad.chunks_exact_mut(width + 1));
        for ((&grad, &winner), (weights, weights_grad)) in grads.zip(rows) {
            if grad == 0.0 {
                continue;
            }
            let point = winner as usize;
            is_winner[point] = true;
            let hidden = &kept.hidden[(cloud * count + point) * width..][..width];
            add_scaled(&mut weights_grad[..width], grad, hidden);
            weights_grad[width] += grad;
            let to = &mut hidden_grad[point * width..][..width];
            add_scaled(to, grad, &weights[..width]);
        }
        for point in (0..count).filter(|&point| is_winner[point]) {
            let index = cloud * count + point;
            let row = &mut hidden_grad[point * width..][..width];
            for (grad, &hidden) in row.iter_mut().zip(&kept.hidden[index * width..]) {
                *grad = if hidden > 0.0 { *grad } else { 0.0 };
            }
            let at = index * columns..(index + 1) * columns;
            point_backward(row, &x[at.clone()], first, &mut x_grad[at], &mut first_grad);
        }
    }
    [x_grad, first_grad, second_t_grad]
}

/// Propagates the gradient of one point's hidden values back to the point and to the first layer.
fn point_backward(
    hidden_grad: &[f32],
    x: &[f32],
    first: &[f32],
    x_grad: &mut [f32],
    first_grad: &mut [f32],
) {
    let width = hidden_grad.len();
    let rows = first.chunks_exact(width);
    let mut grad_rows = first_grad.chunks_exact_mut(width);
    for ((&x, x_grad), (weights, weights_grad)) in
        x.iter().zip(x_grad).zip(rows.zip(&mut grad_rows))
    {
        *x_grad = dot(hidden_grad, weights);
        add_scaled(weights_grad, x, hidden_grad);
    }
    if let Some(bias_grad) = grad_rows.next() {
        add_scaled(bias_grad, 1.0, hidden_grad);
    }
}

fn add_scaled(to: &mut [f32], factor: f32, from: &[f32]) {
    to.iter_mut()
        .zip(from)
        .for_each(|(to, from)| *to += factor * from);
}

/// Summed in eight lanes, so that the compiler uses vector instructions.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0f32; 8];
    let (a, b) = (a.chunks(8), b.chunks(8));
    for (a, b) in a.zip(b) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += a * b;
        }
    }
    lanes.iter().sum()
}

#[cfg(test)]
mod tests;
