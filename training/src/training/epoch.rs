//! Report of one epoch: one pass over the training clouds.

use serde::{Deserialize, Serialize};

use crate::training::tally::Tally;

/// Losses and accuracies of one epoch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpochReport {
    /// Number of the epoch, from 1.
    pub epoch: usize,
    /// Mean negative log-likelihood of the training clouds, while learning.
    pub train_loss: f64,
    /// Share of training clouds named rightly, while learning.
    pub train_accuracy: f64,
    /// Mean negative log-likelihood of the validation clouds.
    pub validation_loss: f64,
    /// Share of validation clouds named rightly.
    pub validation_accuracy: f64,
    /// Whether the validation loss is the lowest so far.
    pub best: bool,
}

impl EpochReport {
    /// The report of these sums; `best` is still false.
    pub(crate) fn of(epoch: usize, train: &Tally, validation: &Tally) -> Self {
        Self {
            epoch,
            train_loss: train.loss(),
            train_accuracy: train.accuracy(),
            validation_loss: validation.loss(),
            validation_accuracy: validation.accuracy(),
            best: false,
        }
    }
}
