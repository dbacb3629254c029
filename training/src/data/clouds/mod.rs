//! Labelled clouds: the network's input with its labels.

mod file;

use anyhow::Result;
use candle_core::{Device, Tensor};
use rand_pcg::Pcg64Mcg;

use super::augment::{Augmentation, augment};

/// The part of a dataset that a cloud belongs to. The numbers are those in the file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Split {
    /// Training set.
    #[default]
    Train = 0,
    /// Validation set: chooses the best epoch.
    Validation = 1,
    /// Test set: evaluated once, after training.
    Test = 2,
}

/// Something computed from a cloud (`taken`), with the cloud's label and how it was seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen<T> {
    /// Index of the class; the number of classes stands for "none of them".
    pub label: u32,
    /// Number of views that the cloud is made of; 0 for the whole surface.
    pub view_count: u32,
    /// Whether a gripper held the object; otherwise it stood on something.
    pub held: bool,
    /// The value computed from the cloud.
    pub taken: T,
}

impl<T> Seen<T> {
    /// The same label and view with another value.
    pub fn with<U>(&self, taken: U) -> Seen<U> {
        Seen {
            label: self.label,
            view_count: self.view_count,
            held: self.held,
            taken,
        }
    }
}

/// M clouds of one point count, with what they show.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LabelledClouds {
    /// N, points of each cloud, in the order of farthest-point sampling: fewer of them are what the node would choose.
    pub point_count: usize,
    /// Values of a point: 3, or 6 with its normal.
    pub columns: usize,
    /// `[M, N, columns]` row-major: coordinates in metres, up along the model's up axis, moved to the origin; then the unit
    /// normal, if any.
    pub values: Vec<f32>,
    /// `[M]` class indices.
    pub labels: Vec<u32>,
    /// `[M]` number of views that each cloud is made of; 0 for a whole surface.
    pub view_counts: Vec<u32>,
    /// `[M]` 1 where a gripper held the object, 0 where it stood on something or is seen from all sides.
    pub held: Vec<u32>,
    /// `[M]` numbers of [`Split`].
    pub split: Vec<u32>,
}

impl LabelledClouds {
    /// No clouds yet; `columns` is 3, or 6 with normals.
    pub fn new(point_count: usize, columns: usize) -> Self {
        Self {
            point_count,
            columns,
            ..Self::default()
        }
    }

    /// Number of clouds, M.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there is no cloud.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// The values of one cloud, `[N, columns]`.
    ///
    /// # Panics
    /// If `index` is not less than [`Self::len`].
    pub fn cloud(&self, index: usize) -> &[f32] {
        let length = self.columns * self.point_count;
        &self.values[index * length..(index + 1) * length]
    }

    /// Adds one cloud, which is the network's input, `[columns, N]`: coordinates in units of `metres_per_unit`, then normals.
    pub fn push(&mut self, seen: &Seen<Vec<f32>>, metres_per_unit: f64, split: Split) {
        for point in 0..self.point_count {
            self.values.extend((0..self.columns).map(|column| {
                let scale = if column < 3 {
                    metres_per_unit as f32
                } else {
                    1.0
                };
                seen.taken[column * self.point_count + point] * scale
            }));
        }
        self.labels.push(seen.label);
        self.view_counts.push(seen.view_count);
        self.held.push(u32::from(seen.held));
        self.split.push(split as u32);
    }

    /// Adds all clouds of `other`, which have the same shape.
    pub fn append(&mut self, other: Self) {
        self.values.extend(other.values);
        self.labels.extend(other.labels);
        self.view_counts.extend(other.view_counts);
        self.held.extend(other.held);
        self.split.extend(other.split);
    }

    /// The clouds of one split, each of its first `point_count` points.
    pub fn part(&self, split: Split, point_count: usize) -> Self {
        let wanted = |index: &usize| self.split[*index] == split as u32;
        let chosen: Vec<usize> = (0..self.len()).filter(wanted).collect();
        let of_chosen = |column: &[u32]| chosen.iter().map(|&index| column[index]).collect();
        let values = chosen
            .iter()
            .flat_map(|&index| &self.cloud(index)[..self.columns * point_count]);
        Self {
            point_count,
            columns: self.columns,
            values: values.copied().collect(),
            labels: of_chosen(&self.labels),
            view_counts: of_chosen(&self.view_counts),
            held: of_chosen(&self.held),
            split: of_chosen(&self.split),
        }
    }

    /// A batch for the network, `[B, N, columns]` in model units; augmented at random if asked for.
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

#[cfg(test)]
mod tests;
