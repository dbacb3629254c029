//! Clouds as tensors.

use anyhow::Result;
use candle_core::{Device, Tensor};
use rand_pcg::Pcg64Mcg;

use crate::augment::{Augmentation, augment};
use crate::samples::Samples;

/// Labelled clouds of one length, borrowed from what holds them.
#[derive(Debug, Clone, Copy)]
pub struct Clouds<'a> {
    /// N, points of each cloud.
    pub point_count: usize,
    /// Values of a point: 3, or 6 with its normal.
    pub columns: usize,
    /// `[M, N, columns]` row-major: coordinates in metres, then the normal if any.
    pub values: &'a [f32],
    /// `[M]` class indices.
    pub labels: &'a [u32],
}

/// What [`Clouds`] borrows from.
#[derive(Debug, Clone)]
pub struct Part {
    /// As in [`Clouds`].
    pub point_count: usize,
    /// As in [`Clouds`].
    pub columns: usize,
    /// As in [`Clouds`].
    pub values: Vec<f32>,
    /// As in [`Clouds`].
    pub labels: Vec<u32>,
}

impl Part {
    /// What the trainer takes.
    pub fn clouds(&self) -> Clouds<'_> {
        Clouds {
            point_count: self.point_count,
            columns: self.columns,
            values: &self.values,
            labels: &self.labels,
        }
    }
}

impl From<Samples> for Part {
    fn from(samples: Samples) -> Self {
        Self {
            point_count: samples.point_count,
            columns: 3,
            values: samples.points,
            labels: samples.labels,
        }
    }
}

impl<'a> From<&'a Samples> for Clouds<'a> {
    fn from(samples: &'a Samples) -> Self {
        Self {
            point_count: samples.point_count,
            columns: 3,
            values: &samples.points,
            labels: &samples.labels,
        }
    }
}

impl<'a> Clouds<'a> {
    /// Number of clouds, M.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there is no cloud.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    fn cloud(&self, index: usize) -> &'a [f32] {
        let length = self.columns * self.point_count;
        &self.values[index * length..(index + 1) * length]
    }

    /// Some clouds as the network takes them, `[B, N, columns]` in units; changed at random if asked for.
    ///
    /// # Errors
    /// Candle fails.
    pub fn tensor(
        &self,
        indices: &[usize],
        metres_per_unit: f64,
        change: Option<(&Augmentation, Pcg64Mcg)>,
    ) -> Result<Tensor> {
        let length = self.columns * self.point_count;
        let mut values = Vec::with_capacity(indices.len() * length);
        indices
            .iter()
            .for_each(|&index| values.extend_from_slice(self.cloud(index)));
        if let Some((augmentation, mut random)) = change {
            let clouds = values.chunks_exact_mut(length);
            clouds.for_each(|cloud| augment(cloud, self.columns, augmentation, &mut random));
        }
        let units_per_metre = (1.0 / metres_per_unit) as f32;
        for point in values.chunks_exact_mut(self.columns) {
            point[..3].iter_mut().for_each(|v| *v *= units_per_metre);
        }
        let shape = (indices.len(), self.point_count, self.columns);
        Ok(Tensor::from_vec(values, shape, &Device::Cpu)?)
    }

    /// Sum of the negative log-probabilities, `[B, C]`, of the true classes.
    ///
    /// # Errors
    /// Candle fails.
    pub fn summed_loss(&self, log_probabilities: &Tensor, indices: &[usize]) -> Result<Tensor> {
        let labels: Vec<u32> = indices.iter().map(|&index| self.labels[index]).collect();
        let labels = Tensor::from_vec(labels, (indices.len(), 1), log_probabilities.device())?;
        Ok(log_probabilities.gather(&labels, 1)?.sum_all()?.neg()?)
    }
}
