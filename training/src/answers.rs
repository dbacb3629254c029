//! What a network says about labelled clouds.

use anyhow::Result;
use classifier::ModelMetadata;
use serde::{Deserialize, Serialize};

use crate::batch::Clouds;
use crate::metrics::{Confusion, threshold_keeping};
use crate::network::Network;
use crate::trainer::{log_probabilities, most_probable};

/// How the network does on clouds that had no part in training.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Test {
    /// How many.
    pub clouds: usize,
    /// Share named rightly.
    pub accuracy: f64,
    /// Mean negative log-likelihood.
    pub loss: f64,
    /// All answers.
    pub confusion: Confusion,
}

/// What a network says about clouds whose classes are known.
pub(crate) struct Answers<'a> {
    log_probabilities: Vec<Vec<f32>>,
    labels: &'a [u32],
}

impl<'a> Answers<'a> {
    /// Asks the network.
    ///
    /// # Errors
    /// The network fails.
    pub fn of(network: &Network, clouds: Clouds<'a>, metadata: &ModelMetadata) -> Result<Self> {
        Ok(Self {
            log_probabilities: log_probabilities(network, clouds, metadata.metres_per_unit)?,
            labels: clouds.labels,
        })
    }

    /// Counted by class.
    pub fn confusion(&self, labels: &[String]) -> Confusion {
        let mut confusion = Confusion::new(labels);
        for (answer, &label) in self.log_probabilities.iter().zip(self.labels) {
            confusion.add(label as usize, most_probable(answer));
        }
        confusion
    }

    /// The probability that this share of the answers reaches.
    pub fn threshold(&self, share: f64) -> f64 {
        let highest = self.log_probabilities.iter();
        let highest = highest.map(|answer| f64::from(answer[most_probable(answer)]).exp());
        threshold_keeping(highest.collect(), share)
    }

    /// All that is said of test clouds.
    pub fn test(&self, labels: &[String]) -> Test {
        let confusion = self.confusion(labels);
        let pairs = self.log_probabilities.iter().zip(self.labels);
        let losses = pairs.map(|(answer, &label)| -f64::from(answer[label as usize]));
        Test {
            clouds: self.labels.len(),
            accuracy: confusion.accuracy(),
            loss: losses.sum::<f64>() / self.labels.len().max(1) as f64,
            confusion,
        }
    }
}
