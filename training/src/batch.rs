//! Clouds as tensors.

use anyhow::Result;
use candle_core::{Device, Tensor};
use rand_pcg::Pcg64Mcg;

use crate::augment::{Augmentation, augment};
use crate::network::Network;
use crate::samples::Samples;

/// How many clouds are worked on at once. Tensors stay in a core's cache, and are so small that candle handles each in
/// one thread: its threads wait for each other in a busy loop, which costs more than it gains where cores are shared.
pub fn part_size(network: &Network, samples: &Samples) -> usize {
    const LARGEST_TENSOR: usize = 60_000;
    let width = network
        .architecture
        .features
        .max(network.architecture.transformer_features);
    (LARGEST_TENSOR / (samples.point_count * width).max(1)).max(1)
}

/// Some clouds as the network takes them, [B, N, 3] in units; changed at random if asked for.
///
/// # Errors
/// Candle fails.
pub fn clouds(
    samples: &Samples,
    indices: &[usize],
    metres_per_unit: f64,
    change: Option<(&Augmentation, Pcg64Mcg)>,
) -> Result<Tensor> {
    let mut points = Vec::with_capacity(indices.len() * 3 * samples.point_count);
    indices
        .iter()
        .for_each(|&index| points.extend(samples.cloud(index)));
    if let Some((augmentation, mut random)) = change {
        let clouds = points.chunks_exact_mut(3 * samples.point_count);
        clouds.for_each(|cloud| augment(cloud, augmentation, &mut random));
    }
    let units_per_metre = (1.0 / metres_per_unit) as f32;
    points
        .iter_mut()
        .for_each(|value| *value *= units_per_metre);
    let shape = (indices.len(), samples.point_count, 3);
    Ok(Tensor::from_vec(points, shape, &Device::Cpu)?)
}

/// Sum of the negative log-probabilities, [B, C], of the true classes.
///
/// # Errors
/// Candle fails.
pub fn summed_loss(
    log_probabilities: &Tensor,
    samples: &Samples,
    indices: &[usize],
) -> Result<Tensor> {
    let labels: Vec<u32> = indices.iter().map(|&index| samples.labels[index]).collect();
    let labels = Tensor::from_vec(labels, (indices.len(), 1), &Device::Cpu)?;
    Ok(log_probabilities.gather(&labels, 1)?.sum_all()?.neg()?)
}
