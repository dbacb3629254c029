//! Fits a network to clouds: Adam, early stopping with patience, best weights kept.

use anyhow::{Result, ensure};
use candle_core::Tensor;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::data::LabelledClouds;
use crate::data::augment::Augmentation;
use crate::network::Network;
use crate::training::checkpoint::{Checkpoint, State};
use crate::training::epoch::EpochReport;
use crate::training::optimizer::Adam;
use crate::training::passes::{evaluate, gradients};
use crate::training::tally::Tally;

/// How to train.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainingParameters {
    /// Largest number of epochs (passes over the training clouds).
    pub epochs: usize,
    /// Number of clouds in one step.
    pub batch_size: usize,
    /// Peak learning rate of Adam; cosine decay to 0 after a short warm-up.
    pub learning_rate: f64,
    /// Decoupled weight decay (Loshchilov & Hutter 2019).
    pub weight_decay: f64,
    /// Early stopping: number of epochs without a better validation loss after which training ends.
    pub patience: usize,
    /// Random changes of the training clouds.
    pub augmentation: Augmentation,
}

impl Default for TrainingParameters {
    fn default() -> Self {
        Self {
            epochs: 32,
            batch_size: 64,
            learning_rate: 3e-3,
            weight_decay: 1e-4,
            patience: 15,
            augmentation: Augmentation::default(),
        }
    }
}

/// Events of training, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// A step was made.
    Step {
        /// Number of the epoch, from 1.
        epoch: usize,
        /// Mean loss of the epoch so far.
        loss: f64,
        /// Accuracy of the epoch so far.
        accuracy: f64,
    },
    /// An epoch ended.
    Epoch(EpochReport),
    /// An interrupted training resumes from its checkpoint.
    Resumed {
        /// Number of epochs that the checkpoint has completed.
        epochs: usize,
        /// Number of their steps.
        steps: usize,
    },
}

/// Trains the network and sets it to the weights with the lowest validation loss. `metres_per_unit` as in the model's
/// metadata. The same arguments give the same network, even if an interrupted training resumes from its checkpoint. The
/// caller removes the checkpoint.
///
/// # Errors
/// There are no clouds, the checkpoint is of another training, or a loss is NaN.
pub fn train(
    network: &Network,
    [train, validation]: [&LabelledClouds; 2],
    metres_per_unit: f64,
    parameters: &TrainingParameters,
    seed: u64,
    checkpoint: Option<&Checkpoint>,
    mut observe: impl FnMut(Event) -> Result<()>,
) -> Result<Vec<EpochReport>> {
    ensure!(
        !train.is_empty() && !validation.is_empty(),
        "there is nothing to train on"
    );
    let mut fit = Fit {
        network,
        train,
        metres_per_unit,
        parameters,
        adam: Adam::new(network.variables(), parameters.weight_decay)?,
        best_weights: network.snapshot()?,
        history: Vec::new(),
    };
    if let Some(state) = checkpoint.map_or(Ok(None), |c| c.read(&fit.best_weights))? {
        let (epochs, steps) = (state.history.len(), state.adam.steps);
        fit.resume(state)?;
        observe(Event::Resumed { epochs, steps })?;
    }
    while !fit.is_finished() {
        let epoch = fit.history.len() + 1;
        let mut random = epoch_random(seed, epoch);
        let learned = fit.epoch(epoch, &mut random, &mut observe)?;
        let found = evaluate(network, validation, metres_per_unit)?;
        refuse_nan(found.loss(), epoch)?;
        let report = fit.end_epoch(EpochReport::of(epoch, &learned, &found))?;
        checkpoint.map_or(Ok(()), |checkpoint| checkpoint.write(&fit.state()?))?;
        observe(Event::Epoch(report))?;
    }
    network.restore(&fit.best_weights)?;
    Ok(fit.history)
}

/// The random generator of one epoch: it depends on the seed and the epoch's number alone.
fn epoch_random(seed: u64, epoch: usize) -> Pcg64Mcg {
    let mut of_training = Pcg64Mcg::seed_from_u64(seed);
    let key: u64 = of_training.random();
    Pcg64Mcg::seed_from_u64(key.wrapping_add(epoch as u64))
}

/// The state of a running training.
struct Fit<'a> {
    network: &'a Network,
    train: &'a LabelledClouds,
    metres_per_unit: f64,
    parameters: &'a TrainingParameters,
    adam: Adam,
    best_weights: Vec<Tensor>,
    history: Vec<EpochReport>,
}

impl Fit<'_> {
    /// The epoch with the lowest validation loss so far.
    fn best(&self) -> Option<&EpochReport> {
        self.history.iter().rev().find(|report| report.best)
    }

    fn is_finished(&self) -> bool {
        let done = self.history.len();
        let best_epoch = self.best().map_or(0, |report| report.epoch);
        done >= self.parameters.epochs || done - best_epoch >= self.parameters.patience
    }

    fn state(&self) -> Result<State> {
        Ok(State {
            weights: self.network.snapshot()?,
            best_weights: self.best_weights.clone(),
            adam: self.adam.state().clone(),
            history: self.history.clone(),
        })
    }

    fn resume(&mut self, state: State) -> Result<()> {
        self.network.restore(&state.weights)?;
        self.best_weights = state.best_weights;
        self.adam.resume(state.adam)?;
        self.history = state.history;
        Ok(())
    }

    /// Keeps the weights if they are the best so far.
    fn end_epoch(&mut self, mut report: EpochReport) -> Result<EpochReport> {
        let lowest = self
            .best()
            .map_or(f64::INFINITY, |best| best.validation_loss);
        report.best = report.validation_loss < lowest;
        if report.best {
            self.best_weights = self.network.snapshot()?;
        }
        self.history.push(report);
        Ok(report)
    }

    /// One pass over the clouds in random order.
    fn epoch(
        &mut self,
        epoch: usize,
        random: &mut Pcg64Mcg,
        observe: &mut impl FnMut(Event) -> Result<()>,
    ) -> Result<Tally> {
        let mut order: Vec<usize> = (0..self.train.len()).collect();
        order.shuffle(random);
        let (batch_size, highest) = (self.parameters.batch_size, self.parameters.learning_rate);
        let steps = self.parameters.epochs * order.len().div_ceil(batch_size);
        let mut tally = Tally::default();
        for indices in order.chunks(batch_size) {
            let progress = self.adam.state().steps as f64 / steps as f64;
            let change = (&self.parameters.augmentation, Pcg64Mcg::from_rng(random));
            let scale = self.metres_per_unit;
            let (gradients, part) = gradients(self.network, self.train, indices, scale, change)?;
            self.adam
                .step(&gradients, learning_rate(highest, progress))?;
            tally.add(part);
            let (loss, accuracy) = (tally.loss(), tally.accuracy());
            refuse_nan(loss, epoch)?;
            observe(Event::Step {
                epoch,
                loss,
                accuracy,
            })?;
        }
        Ok(tally)
    }
}

fn refuse_nan(loss: f64, epoch: usize) -> Result<()> {
    ensure!(
        loss.is_finite(),
        "the loss is not a number any more in epoch {epoch}; lower learning_rate"
    );
    Ok(())
}

/// Learning rate schedule: linear warm-up, then cosine decay. `progress` runs from 0 to 1.
fn learning_rate(highest: f64, progress: f64) -> f64 {
    const WARM_UP: f64 = 0.02;
    if progress < WARM_UP {
        return highest * (0.1 + 0.9 * progress / WARM_UP);
    }
    0.5 * highest * (1.0 + ((progress - WARM_UP) / (1.0 - WARM_UP) * std::f64::consts::PI).cos())
}
