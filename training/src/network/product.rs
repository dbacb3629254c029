//! Matrix products, forward and backward, computed in the calling thread.
//!
//! Candle's own product looks up the number of cores in /proc at each call, which takes longer than the product of matrices
//! as small as ours, and it may use threads that are busy with other clouds. On a GPU candle's own product is used.

use candle_core::{CpuStorage, CustomOp2, Layout, Result, Shape, Tensor, bail};
use nalgebra::{DMatrix, DMatrixView};

use crate::network::fused::{values, with_values};

/// `a` [M, K] · `b` [K, N].
///
/// # Errors
/// The shapes do not fit.
pub fn product(a: &Tensor, b: &Tensor) -> Result<Tensor> {
    let (a, b) = (a.contiguous()?, b.contiguous()?);
    if !a.device().is_cpu() {
        return a.matmul(&b);
    }
    a.apply_op2(&b, Product)
}

/// Each of `clouds` [B, N, 3] times its own `turns` [B, 3, 3].
///
/// # Errors
/// The shapes do not fit.
pub fn turned(clouds: &Tensor, turns: &Tensor) -> Result<Tensor> {
    let (clouds, turns) = (clouds.contiguous()?, turns.contiguous()?);
    if !clouds.device().is_cpu() {
        return clouds.matmul(&turns);
    }
    clouds.apply_op2(&turns, Turned)
}

/// `a` [M, K] · `b` [K, N], all row-major: for nalgebra, whose matrices are column-major, they are transposed.
pub(crate) fn multiply(a: &[f32], b: &[f32], [m, k, n]: [usize; 3]) -> DMatrix<f32> {
    DMatrixView::from_slice(b, n, k) * DMatrixView::from_slice(a, k, m)
}

struct Product;

impl CustomOp2 for Product {
    fn name(&self) -> &'static str {
        "product"
    }

    fn cpu_fwd(
        &self,
        a: &CpuStorage,
        a_l: &Layout,
        b: &CpuStorage,
        b_l: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let ((m, k), (rows, n)) = (a_l.shape().dims2()?, b_l.shape().dims2()?);
        if rows != k {
            bail!("{:?} does not fit {:?}", a_l.shape(), b_l.shape());
        }
        let result = multiply(values(a, a_l)?, values(b, b_l)?, [m, k, n]);
        let result = CpuStorage::F32(result.data.into());
        Ok((result, Shape::from((m, n))))
    }

    fn bwd(
        &self,
        a: &Tensor,
        b: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let ((m, k), n) = (a.dims2()?, b.dim(1)?);
        let (a_t, b_t) = (a.t()?, b.t()?);
        let times = |left: &Tensor, right: &Tensor, sizes: [usize; 3]| {
            let values = with_values(left, |left| {
                with_values(right, |right| Ok(multiply(left, right, sizes)))
            })?;
            let values: Vec<f32> = values.data.into();
            Tensor::from_vec(values, (sizes[0], sizes[2]), a.device())
        };
        let a_grad = times(grad, &b_t, [m, n, k])?;
        Ok((Some(a_grad), Some(times(&a_t, grad, [k, m, n])?)))
    }
}

struct Turned;

impl CustomOp2 for Turned {
    fn name(&self) -> &'static str {
        "turned"
    }

    fn cpu_fwd(
        &self,
        clouds: &CpuStorage,
        clouds_l: &Layout,
        turns: &CpuStorage,
        turns_l: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let (batch, count, three) = clouds_l.shape().dims3()?;
        if three != 3 || turns_l.dims() != [batch, 3, 3] {
            bail!("{:?} does not fit {:?}", clouds_l.shape(), turns_l.shape());
        }
        let (clouds, turns) = (values(clouds, clouds_l)?, values(turns, turns_l)?);
        let mut result = Vec::with_capacity(clouds.len());
        for (cloud, turn) in clouds.chunks_exact(3 * count).zip(turns.chunks_exact(9)) {
            for point in cloud.chunks_exact(3) {
                result.extend([0, 1, 2].map(|axis| {
                    point[0] * turn[axis] + point[1] * turn[3 + axis] + point[2] * turn[6 + axis]
                }));
            }
        }
        Ok((CpuStorage::F32(result), clouds_l.shape().clone()))
    }

    fn bwd(
        &self,
        clouds: &Tensor,
        turns: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let length = 3 * clouds.dim(1)?;
        let [clouds_grad, turns_grad] = with_values(clouds, |clouds| {
            with_values(turns, |turns| {
                with_values(grad, |grad| {
                    Ok(turned_backward([clouds, turns, grad], length))
                })
            })
        })?;
        let tensor = |values, like: &Tensor| Tensor::from_vec(values, like.shape(), like.device());
        Ok((
            Some(tensor(clouds_grad, clouds)?),
            Some(tensor(turns_grad, turns)?),
        ))
    }
}

/// Gradients of the clouds, of `length` values each, and of their turns.
fn turned_backward([clouds, turns, grad]: [&[f32]; 3], length: usize) -> [Vec<f32>; 2] {
    let mut clouds_grad = Vec::with_capacity(clouds.len());
    let mut turns_grad = vec![0.0; turns.len()];
    let clouds = clouds.chunks_exact(length).zip(grad.chunks_exact(length));
    let turns = turns.chunks_exact(9).zip(turns_grad.chunks_exact_mut(9));
    for ((cloud, grad), (turn, turn_grad)) in clouds.zip(turns) {
        for (point, grad) in cloud.chunks_exact(3).zip(grad.chunks_exact(3)) {
            for row in 0..3 {
                let weights = &turn[3 * row..3 * row + 3];
                clouds_grad.push(weights.iter().zip(grad).map(|(w, g)| w * g).sum());
                for (sum, grad) in turn_grad[3 * row..3 * row + 3].iter_mut().zip(grad) {
                    *sum += point[row] * grad;
                }
            }
        }
    }
    [clouds_grad, turns_grad]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use candle_core::Var;

    use super::super::testing::{largest_difference, random};
    use super::*;

    /// Compares with candle's own product: values, and gradients under a random weighting.
    fn assert_as_candle(a: &Var, b: &Var, result: &Tensor) {
        let plain = a.matmul(b).unwrap();
        assert!(largest_difference(result, &plain) < 1e-4);
        let weights = random(result.shape());
        let gradients = |result: &Tensor| {
            let weighted = (result * weights.as_tensor()).unwrap();
            weighted.sum_all().unwrap().backward().unwrap()
        };
        let (ours, plain) = (gradients(result), gradients(&plain));
        for variable in [a, b] {
            let (ours, plain) = (ours.get(variable).unwrap(), plain.get(variable).unwrap());
            assert!(largest_difference(ours, plain) < 1e-4);
        }
    }

    #[test]
    fn products_are_those_of_candle() {
        for [m, k, n] in [[1, 1, 1], [5, 3, 9], [70, 40, 11]] {
            let (a, b) = (random((m, k)), random((k, n)));
            assert_as_candle(&a, &b, &product(&a, &b).unwrap());
        }
        let (clouds, turns) = (random((4, 7, 3)), random((4, 3, 3)));
        assert_as_candle(&clouds, &turns, &turned(&clouds, &turns).unwrap());
    }

    #[test]
    fn shapes_that_do_not_fit_are_refused() {
        assert!(product(&random((2, 3)), &random((4, 2))).is_err());
        assert!(turned(&random((2, 5, 3)), &random((3, 3, 3))).is_err());
    }
}
