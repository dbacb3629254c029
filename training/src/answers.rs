//! What a network says about labelled clouds.

use anyhow::Result;
use classifier::ModelMetadata;
use serde::{Deserialize, Serialize};

use crate::batch::Clouds;
use crate::calibration::{
    calibration_error, highest_probability, inverse_temperature, log_sum_exp,
};
use crate::metrics::{Confusion, threshold_keeping};
use crate::network::Network;
use crate::trainer::{logits, most_probable};

/// How the network does on clouds that had no part in training.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Test {
    /// How many.
    pub clouds: usize,
    /// Share named rightly.
    pub accuracy: f64,
    /// Mean negative log-likelihood.
    pub loss: f64,
    /// Expected calibration error: how far probabilities are from shares of right answers.
    pub calibration_error: f64,
    /// All answers.
    pub confusion: Confusion,
}

/// What a network says about clouds of its classes.
pub(crate) struct Answers {
    logits: Vec<Vec<f32>>,
    labels: Vec<usize>,
}

impl Answers {
    /// Of the clouds that are of a class; strangers are left out.
    pub fn of(network: &Network, clouds: Clouds, metadata: &ModelMetadata) -> Result<Self> {
        let logits = logits(network, clouds, metadata.metres_per_unit)?;
        let labels = clouds.labels.iter().map(|&label| label as usize);
        let own = logits.into_iter().zip(labels);
        let (logits, labels) = own.filter(|(_, label)| *label < network.classes()).unzip();
        Ok(Self { logits, labels })
    }

    /// Counted by class.
    pub fn confusion(&self, labels: &[String]) -> Confusion {
        let mut confusion = Confusion::new(labels);
        for (logits, &label) in self.logits.iter().zip(&self.labels) {
            confusion.add(label, most_probable(logits));
        }
        confusion
    }

    /// See [`inverse_temperature`].
    pub fn inverse_temperature(&self) -> f64 {
        inverse_temperature(&self.logits, &self.labels)
    }

    /// The negative energy that this share of the clouds reaches.
    pub fn threshold(&self, share: f64) -> f64 {
        threshold_keeping(self.logits.iter().map(|l| log_sum_exp(l)).collect(), share)
    }

    /// All that is said of test clouds; `inverse_temperature` as found on other clouds.
    pub fn test(&self, labels: &[String], inverse_temperature: f64) -> Test {
        let confusion = self.confusion(labels);
        let tempered = |logits: &[f32]| -> Vec<f32> {
            let scaled: Vec<f32> = logits
                .iter()
                .map(|l| l * inverse_temperature as f32)
                .collect();
            let sum = log_sum_exp(&scaled) as f32;
            scaled.into_iter().map(|l| l - sum).collect()
        };
        let answers: Vec<Vec<f32>> = self.logits.iter().map(|l| tempered(l)).collect();
        let loss: f64 = answers
            .iter()
            .zip(&self.labels)
            .map(|(a, &l)| -f64::from(a[l]))
            .sum();
        let judged: Vec<(f64, bool)> = answers
            .iter()
            .zip(&self.labels)
            .map(|(answer, &label)| (highest_probability(answer), most_probable(answer) == label))
            .collect();
        Test {
            clouds: self.labels.len(),
            accuracy: confusion.accuracy(),
            loss: loss / self.labels.len().max(1) as f64,
            calibration_error: calibration_error(&judged),
            confusion,
        }
    }
}
