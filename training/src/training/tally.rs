//! Sums of losses and right answers.

use crate::data::LabelledClouds;

/// Sums over some clouds.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    loss_sum: f64,
    right: usize,
    count: usize,
}

impl Tally {
    /// Sums over these clouds, of whose log-probabilities `answers` holds one entry each.
    pub fn of(answers: &[Vec<f32>], clouds: &LabelledClouds, indices: &[usize]) -> Self {
        let mut tally = Self::default();
        for (answer, &index) in answers.iter().zip(indices) {
            let label = clouds.labels[index] as usize;
            tally.loss_sum -= f64::from(answer[label]);
            tally.right += usize::from(most_probable(answer) == label);
            tally.count += 1;
        }
        tally
    }

    pub fn add(&mut self, other: Self) {
        self.loss_sum += other.loss_sum;
        self.right += other.right;
        self.count += other.count;
    }

    pub fn loss(&self) -> f64 {
        self.loss_sum / self.count as f64
    }

    pub fn accuracy(&self) -> f64 {
        self.right as f64 / self.count as f64
    }
}

/// Index of the largest value.
pub fn most_probable(log_probabilities: &[f32]) -> usize {
    let best = log_probabilities
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1));
    best.map_or(0, |(index, _)| index)
}
