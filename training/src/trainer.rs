//! Fits a network to clouds: Adam, early stop by patience, the best weights kept.

use anyhow::{Result, ensure};
use candle_core::backprop::GradStore;
use candle_nn::{AdamW, Optimizer, ParamsAdamW};
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::augment::Augmentation;
use crate::batch::{clouds, part_size, summed_loss};
use crate::network::Network;
use crate::samples::Samples;

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingParameters {
    /// Most passes over the training clouds.
    pub epochs: usize,
    /// Clouds a step.
    pub batch_size: usize,
    /// Adam's step size at its highest; it falls to nothing along half a cosine.
    pub learning_rate: f64,
    /// Decoupled weight decay (Loshchilov & Hutter 2019).
    pub weight_decay: f64,
    /// Epochs without a better validation loss after which training ends.
    pub patience: usize,
    /// Changes that clouds undergo.
    pub augmentation: Augmentation,
}

impl Default for TrainingParameters {
    fn default() -> Self {
        Self {
            epochs: 40,
            batch_size: 64,
            learning_rate: 3e-3,
            weight_decay: 1e-4,
            patience: 15,
            augmentation: Augmentation::default(),
        }
    }
}

/// What one epoch achieved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EpochReport {
    /// From 1.
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

/// What happens while training, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// A step was made.
    Step {
        /// From 1.
        epoch: usize,
        /// Mean loss of the epoch so far.
        loss: f64,
        /// Accuracy of the epoch so far.
        accuracy: f64,
    },
    /// An epoch ended.
    Epoch(EpochReport),
}

/// Trains, and leaves the network with the weights of the lowest validation loss. `metres_per_unit` as in the model's
/// metadata. The same arguments give the same network.
///
/// # Errors
/// No clouds, or a loss that is not a number.
pub fn train(
    network: &Network,
    [train, validation]: [&Samples; 2],
    metres_per_unit: f64,
    parameters: &TrainingParameters,
    random: &mut Pcg64Mcg,
    mut observe: impl FnMut(Event) -> Result<()>,
) -> Result<Vec<EpochReport>> {
    ensure!(
        !train.is_empty() && !validation.is_empty(),
        "there is nothing to train on"
    );
    let settings = ParamsAdamW {
        weight_decay: parameters.weight_decay,
        ..ParamsAdamW::default()
    };
    let optimizer = AdamW::new(network.variables(), settings)?;
    let mut fit = Fit {
        network,
        train,
        metres_per_unit,
        parameters,
        optimizer,
        epoch: 0,
        step: 0,
    };
    let mut order: Vec<usize> = (0..train.len()).collect();
    let mut history: Vec<EpochReport> = Vec::new();
    let mut best = (f64::INFINITY, 0, network.snapshot()?);
    while fit.epoch < parameters.epochs && fit.epoch - best.1 < parameters.patience {
        order.shuffle(random);
        let learned = fit.epoch(&order, random, &mut observe)?;
        let found = evaluate(network, validation, metres_per_unit)?;
        let report = report(fit.epoch, &learned, &found, best.0);
        if report.best {
            best = (report.validation_loss, fit.epoch, network.snapshot()?);
        }
        history.push(report);
        observe(Event::Epoch(report))?;
    }
    network.restore(&best.2)?;
    Ok(history)
}

/// Training under way.
struct Fit<'a> {
    network: &'a Network,
    train: &'a Samples,
    metres_per_unit: f64,
    parameters: &'a TrainingParameters,
    optimizer: AdamW,
    epoch: usize,
    step: usize,
}

impl Fit<'_> {
    /// One pass over the clouds in this order.
    fn epoch(
        &mut self,
        order: &[usize],
        random: &mut Pcg64Mcg,
        observe: &mut impl FnMut(Event) -> Result<()>,
    ) -> Result<Tally> {
        self.epoch += 1;
        let epoch = self.epoch;
        let (batch_size, highest) = (self.parameters.batch_size, self.parameters.learning_rate);
        let steps = self.parameters.epochs * order.len().div_ceil(batch_size);
        let mut tally = Tally::default();
        for indices in order.chunks(batch_size) {
            let progress = self.step as f64 / steps as f64;
            self.optimizer
                .set_learning_rate(learning_rate(highest, progress));
            let change = (&self.parameters.augmentation, Pcg64Mcg::from_rng(random));
            let scale = self.metres_per_unit;
            let (gradients, part) = gradients(self.network, self.train, indices, scale, change)?;
            self.optimizer.step(&gradients)?;
            self.step += 1;
            tally.add(part);
            let (loss, accuracy) = (tally.loss(), tally.accuracy());
            ensure!(
                loss.is_finite(),
                "the loss is not a number any more in epoch {epoch}; lower learning_rate"
            );
            observe(Event::Step {
                epoch,
                loss,
                accuracy,
            })?;
        }
        Ok(tally)
    }
}

/// Gradients of the mean loss of some clouds. They are worked on in parts, side by side.
fn gradients(
    network: &Network,
    samples: &Samples,
    indices: &[usize],
    metres_per_unit: f64,
    (augmentation, mut random): (&Augmentation, Pcg64Mcg),
) -> Result<(GradStore, Tally)> {
    let parts = indices.chunks(part_size(network, samples));
    let parts: Vec<_> = parts
        .map(|part| (part, Pcg64Mcg::from_rng(&mut random)))
        .collect();
    let parts: Vec<Result<(GradStore, Tally)>> = parts
        .into_par_iter()
        .map(|(part, random)| {
            let clouds = clouds(samples, part, metres_per_unit, Some((augmentation, random)))?;
            let answers = network.forward_open(&clouds)?;
            let loss = summed_loss(&answers, samples, part)?;
            let gradients = (&loss / indices.len() as f64)?.backward()?;
            Ok((gradients, Tally::of(&answers.to_vec2()?, samples, part)))
        })
        .collect();
    // In order, so that rounding does not depend on which part was ready first.
    let mut total = Tally::default();
    let mut summed: Option<GradStore> = None;
    for part in parts {
        let (gradients, tally) = part?;
        total.add(tally);
        match &mut summed {
            Some(summed) => summed.extend(gradients)?,
            None => summed = Some(gradients),
        }
    }
    summed
        .map(|gradients| (gradients, total))
        .ok_or_else(|| anyhow::anyhow!("an empty batch"))
}

/// Log-probabilities of each cloud.
///
/// # Errors
/// The network fails.
pub fn log_probabilities(
    network: &Network,
    samples: &Samples,
    metres_per_unit: f64,
) -> Result<Vec<Vec<f32>>> {
    let indices: Vec<usize> = (0..samples.len()).collect();
    let answers: Vec<Result<Vec<Vec<f32>>>> = indices
        .par_chunks(part_size(network, samples))
        .map(|part| {
            Ok(network
                .forward_open(&clouds(samples, part, metres_per_unit, None)?)?
                .to_vec2()?)
        })
        .collect();
    let answers: Result<Vec<_>> = answers.into_iter().collect();
    Ok(answers?.concat())
}

fn evaluate(network: &Network, samples: &Samples, metres_per_unit: f64) -> Result<Tally> {
    let indices: Vec<usize> = (0..samples.len()).collect();
    Ok(Tally::of(
        &log_probabilities(network, samples, metres_per_unit)?,
        samples,
        &indices,
    ))
}

fn report(epoch: usize, train: &Tally, validation: &Tally, best_loss: f64) -> EpochReport {
    EpochReport {
        epoch,
        train_loss: train.loss(),
        train_accuracy: train.accuracy(),
        validation_loss: validation.loss(),
        validation_accuracy: validation.accuracy(),
        best: validation.loss() < best_loss,
    }
}

/// A short warm-up, then half a cosine; `progress` runs from 0 to 1.
fn learning_rate(highest: f64, progress: f64) -> f64 {
    const WARM_UP: f64 = 0.02;
    if progress < WARM_UP {
        return highest * (0.1 + 0.9 * progress / WARM_UP);
    }
    0.5 * highest * (1.0 + ((progress - WARM_UP) / (1.0 - WARM_UP) * std::f64::consts::PI).cos())
}

/// Sums of losses and right answers.
#[derive(Debug, Default)]
struct Tally {
    loss_sum: f64,
    right: usize,
    count: usize,
}

impl Tally {
    fn of(answers: &[Vec<f32>], samples: &Samples, indices: &[usize]) -> Self {
        let mut tally = Self::default();
        for (answer, &index) in answers.iter().zip(indices) {
            let label = samples.labels[index] as usize;
            tally.loss_sum -= f64::from(answer[label]);
            tally.right += usize::from(most_probable(answer) == label);
            tally.count += 1;
        }
        tally
    }

    fn add(&mut self, other: Self) {
        self.loss_sum += other.loss_sum;
        self.right += other.right;
        self.count += other.count;
    }

    fn loss(&self) -> f64 {
        self.loss_sum / self.count as f64
    }

    fn accuracy(&self) -> f64 {
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
