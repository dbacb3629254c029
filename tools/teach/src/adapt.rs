//! Adapting: the layers fitted to one more class, then temperature and threshold.

use adaptation::calibration::{Prior, inverse_temperature_near, log_sum_exp, threshold_near};
use adaptation::{Block, FeatureRows, FitSettings, Head, fit};
use anyhow::{Context, Result};

use crate::history::Step;
use crate::judge::{Judge, logits};
use crate::stored::{Changed, Stored};

/// Largest number of clouds of each label that are kept: for fitting the layers, and for calibration.
pub const KEPT_MAX: [usize; 2] = [240, 120];
/// Weight of the prior: the temperature and the threshold of the model in force count as much as this many clouds.
const PRIOR_CLOUDS: f64 = 200.0;
/// The threshold of the known score is chosen so that it accepts this share of the clouds of known objects. The same as in training.
const KNOWN_SHARE: f64 = 0.95;

/// A model's new layers with what is fitted to them.
#[derive(Debug, Clone)]
pub struct Adapted {
    /// The layers.
    pub head: Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// Threshold of the known score.
    pub known_threshold: f64,
    /// A block for each label in order, and one of strangers.
    pub blocks: Vec<Block>,
}

impl Adapted {
    /// With the step that led to it.
    pub fn changed(self, step: Step) -> Changed {
        Changed {
            head: self.head,
            inverse_temperature: self.inverse_temperature,
            known_threshold: self.known_threshold,
            blocks: self.blocks,
            step,
        }
    }

    /// What judges answers of these layers.
    pub fn judge(&self) -> Judge<'_> {
        Judge {
            head: &self.head,
            inverse_temperature: self.inverse_temperature,
            known_threshold: self.known_threshold,
        }
    }
}

/// Fits the layers of a model to what it knows and one more class, and then temperature and threshold.
///
/// # Errors
/// The features have no strangers.
pub fn adapt(
    stored: &Stored,
    new: Block,
    settings: &FitSettings,
    go_on: impl FnMut(usize) -> bool,
) -> Result<Adapted> {
    let mut blocks = stored.kept.blocks.clone();
    let strangers = blocks.pop().filter(|block| block.label.is_none());
    let strangers = strangers.context("the features beside the model have no strangers")?;
    blocks.push(new);
    let rows: Vec<FeatureRows> = blocks.iter().map(|block| block.fit.clone()).collect();
    let head = fit(
        &stored.head.with_class(),
        &rows,
        &strangers.fit,
        settings,
        go_on,
    );
    blocks.push(strangers);
    Ok(calibrated(stored, head, blocks))
}

/// Layers with temperature and threshold as their check clouds and those of before have it.
pub fn calibrated(stored: &Stored, head: Head, blocks: Vec<Block>) -> Adapted {
    let (mut all, mut labels) = (Vec::new(), Vec::new());
    let known = blocks.iter().filter(|block| block.label.is_some());
    for (class, block) in known.enumerate() {
        let logits = logits(&head, &block.check);
        labels.extend(std::iter::repeat_n(class, logits.len()));
        all.extend(logits);
    }
    let prior = |value| Prior {
        value,
        clouds: PRIOR_CLOUDS,
    };
    let scores = all.iter().map(|logits| log_sum_exp(logits)).collect();
    Adapted {
        inverse_temperature: inverse_temperature_near(
            &all,
            &labels,
            prior(stored.inverse_temperature),
        ),
        known_threshold: threshold_near(
            scores,
            KNOWN_SHARE,
            prior(stored.metadata.known_threshold),
        ),
        head,
        blocks,
    }
}
