//! Fits a network to clouds: Adam, early stop by patience, the best weights kept.

use anyhow::{Result, bail, ensure};
use candle_core::{Device, Tensor};
use candle_nn::{AdamW, Optimizer, ParamsAdamW, loss::nll};
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::augment::{Augmentation, augment};
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
            epochs: 24,
            batch_size: 64,
            learning_rate: 3e-3,
            weight_decay: 1e-4,
            patience: 8,
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
    let mut optimizer = AdamW::new(network.variables(), settings)?;
    let mut order: Vec<usize> = (0..train.len()).collect();
    let mut history: Vec<EpochReport> = Vec::new();
    let mut best = (f64::INFINITY, 0, network.snapshot()?);
    let steps = train.len().div_ceil(parameters.batch_size);
    for epoch in 1..=parameters.epochs {
        order.shuffle(random);
        let mut tally = Tally::default();
        for (step, indices) in order.chunks(parameters.batch_size).enumerate() {
            let progress = ((epoch - 1) * steps + step) as f64 / (parameters.epochs * steps) as f64;
            optimizer.set_learning_rate(learning_rate(parameters.learning_rate, progress));
            let seed = Pcg64Mcg::from_rng(random);
            let clouds = batch(
                train,
                indices,
                metres_per_unit,
                Some((&parameters.augmentation, seed)),
            )?;
            let (log_probabilities, targets) =
                (network.forward(&clouds)?, targets(train, indices)?);
            let loss = nll(&log_probabilities, &targets)?;
            optimizer.backward_step(&loss)?;
            tally.add(&log_probabilities, loss.to_scalar::<f32>()?, train, indices)?;
            if !tally.loss().is_finite() {
                bail!("the loss is not a number any more in epoch {epoch}; lower learning_rate");
            }
            observe(Event::Step {
                epoch,
                loss: tally.loss(),
                accuracy: tally.accuracy(),
            })?;
        }
        let report = report(
            epoch,
            &tally,
            evaluate(network, validation, metres_per_unit)?,
            best.0,
        );
        if report.best {
            best = (report.validation_loss, epoch, network.snapshot()?);
        }
        history.push(report);
        observe(Event::Epoch(report))?;
        if epoch - best.1 >= parameters.patience {
            break;
        }
    }
    network.restore(&best.2)?;
    Ok(history)
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
    let mut all = Vec::with_capacity(samples.len());
    for indices in indices.chunks(64) {
        all.extend(
            network
                .forward(&batch(samples, indices, metres_per_unit, None)?)?
                .to_vec2::<f32>()?,
        );
    }
    Ok(all)
}

fn evaluate(network: &Network, samples: &Samples, metres_per_unit: f64) -> Result<Tally> {
    let mut tally = Tally::default();
    for (answer, &label) in log_probabilities(network, samples, metres_per_unit)?
        .iter()
        .zip(&samples.labels)
    {
        tally.add_one(answer, label);
        tally.loss_sum -= f64::from(answer[label as usize]);
    }
    Ok(tally)
}

fn report(epoch: usize, train: &Tally, validation: Tally, best_loss: f64) -> EpochReport {
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

/// Clouds as the network takes them, [B, N, 3] in units.
fn batch(
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
        points
            .chunks_exact_mut(3 * samples.point_count)
            .for_each(|cloud| augment(cloud, augmentation, &mut random));
    }
    let units_per_metre = (1.0 / metres_per_unit) as f32;
    points
        .iter_mut()
        .for_each(|value| *value *= units_per_metre);
    Ok(Tensor::from_vec(
        points,
        (indices.len(), samples.point_count, 3),
        &Device::Cpu,
    )?)
}

fn targets(samples: &Samples, indices: &[usize]) -> Result<Tensor> {
    let labels: Vec<u32> = indices.iter().map(|&index| samples.labels[index]).collect();
    Ok(Tensor::from_vec(labels, indices.len(), &Device::Cpu)?)
}

/// Sums of losses and right answers.
#[derive(Debug, Default)]
struct Tally {
    loss_sum: f64,
    right: usize,
    count: usize,
}

impl Tally {
    fn add(
        &mut self,
        answers: &Tensor,
        mean_loss: f32,
        samples: &Samples,
        indices: &[usize],
    ) -> Result<()> {
        for (answer, &index) in answers.to_vec2::<f32>()?.iter().zip(indices) {
            self.add_one(answer, samples.labels[index]);
        }
        self.loss_sum += f64::from(mean_loss) * indices.len() as f64;
        Ok(())
    }

    fn add_one(&mut self, answer: &[f32], label: u32) {
        self.right += usize::from(most_probable(answer) == label as usize);
        self.count += 1;
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
