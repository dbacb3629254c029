//! A network's answers about labelled clouds.

use anyhow::Result;
use classifier::ModelMetadata;

use crate::data::LabelledClouds;
use crate::evaluation::calibration::{inverse_temperature, log_sum_exp, threshold_keeping};
use crate::evaluation::confusion::Confusion;
use crate::evaluation::test_result::{Answered, TestResult};
use crate::network::Network;
use crate::training::passes::logits;
use crate::training::tally::most_probable;

/// A network's answers about clouds of its classes.
pub(crate) struct Answers {
    logits: Vec<Vec<f32>>,
    labels: Vec<usize>,
}

impl Answers {
    /// Runs the network on the clouds that belong to a class; clouds of strangers are left out.
    pub fn of(
        network: &Network,
        clouds: &LabelledClouds,
        metadata: &ModelMetadata,
    ) -> Result<Self> {
        let logits = logits(network, clouds, metadata.metres_per_unit)?;
        let labels = clouds.labels.iter().map(|&label| label as usize);
        let own = logits.into_iter().zip(labels);
        let (logits, labels) = own.filter(|(_, label)| *label < network.classes()).unzip();
        Ok(Self { logits, labels })
    }

    /// Confusion matrix of the answers.
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

    /// The negative energy (log-sum-exp of the logits) that this share of the clouds reaches.
    pub fn threshold(&self, share: f64) -> f64 {
        threshold_keeping(self.logits.iter().map(|l| log_sum_exp(l)).collect(), share)
    }

    /// Test result of a model with this metadata; `inverse_temperature` was fitted on other clouds.
    pub fn test(&self, metadata: &ModelMetadata, inverse_temperature: f64) -> TestResult {
        let tempered = |logits: &[f32]| -> Vec<f32> {
            let factor = inverse_temperature as f32;
            let scaled: Vec<f32> = logits.iter().map(|logit| factor * logit).collect();
            let sum = log_sum_exp(&scaled) as f32;
            scaled.into_iter().map(|logit| logit - sum).collect()
        };
        let answers: Vec<Vec<f32>> = self.logits.iter().map(|l| tempered(l)).collect();
        let truths = self.logits.iter().zip(&self.labels);
        let answered = answers
            .iter()
            .zip(truths)
            .map(|(answer, (logits, &label))| Answered {
                log_probabilities: answer,
                known_score: log_sum_exp(logits),
                label,
            });
        TestResult::of(&metadata.labels, metadata.known_threshold, answered)
    }
}
