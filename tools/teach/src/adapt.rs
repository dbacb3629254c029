//! Adapting: the layers fitted to one more class, then temperature and threshold.

use adaptation::calibration::{Prior, inverse_temperature_near, threshold_between};
use adaptation::{Block, Familiar, FeatureRows, FitSettings, Head, fit};
use anyhow::{Context, Result};
use classifier::{KnownBy, TestCloud};

use crate::history::Step;
use crate::judge::{Judge, logits};
use crate::stored::{Changed, Stored};

/// Weight of the prior: the temperature of the model in force counts as much as this many clouds.
const PRIOR_CLOUDS: f64 = 200.0;
/// The threshold of the known score is chosen so that it accepts this share of the clouds of known objects. The same as in training.
const KNOWN_SHARE: f64 = 0.95;
/// But of the strangers it accepts this share at most.
const STRANGERS_SHARE: f64 = 0.1;

/// A model's new layers with what is fitted to them.
#[derive(Debug, Clone)]
pub struct Adapted {
    /// The layers.
    pub head: Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// What gives the known score.
    pub familiar: Familiar,
    /// Threshold of the known score.
    pub known_threshold: f64,
    /// A block for each label in order, and one of strangers.
    pub blocks: Vec<Block>,
}

impl Adapted {
    /// With the clouds of its self-test and the step that led to it.
    pub fn changed(self, self_test: Vec<TestCloud>, step: Step) -> Changed {
        Changed {
            self_test,
            head: self.head,
            inverse_temperature: self.inverse_temperature,
            known_threshold: self.known_threshold,
            known_by: KnownBy::Features,
            blocks: self.blocks,
            step,
        }
    }

    /// What judges answers of these layers.
    pub fn judge(&self) -> Judge<'_> {
        Judge {
            head: &self.head,
            inverse_temperature: self.inverse_temperature,
            familiar: Some(&self.familiar),
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
    calibrated(stored, head, blocks)
}

/// Layers with temperature and threshold as the check clouds of known objects and of strangers have it.
///
/// # Errors
/// There are no clouds of an object.
pub fn calibrated(stored: &Stored, head: Head, blocks: Vec<Block>) -> Result<Adapted> {
    let familiar =
        Familiar::of_known(&blocks).context("the features beside the model lack an object")?;
    let (known, strangers): (Vec<&Block>, Vec<&Block>) =
        blocks.iter().partition(|block| block.label.is_some());
    let scores = |blocks: &[&Block]| -> Vec<f64> {
        let scores = blocks.iter().map(|block| familiar.scores(&block.check));
        scores.flatten().collect()
    };
    let (mut all, mut labels) = (Vec::new(), Vec::new());
    for (class, block) in known.iter().enumerate() {
        let logits = logits(&head, &block.check);
        labels.extend(std::iter::repeat_n(class, logits.len()));
        all.extend(logits);
    }
    let prior = Prior {
        value: stored.inverse_temperature,
        clouds: PRIOR_CLOUDS,
    };
    Ok(Adapted {
        inverse_temperature: inverse_temperature_near(&all, &labels, prior),
        known_threshold: threshold_between(
            scores(&known),
            KNOWN_SHARE,
            scores(&strangers),
            STRANGERS_SHARE,
        ),
        familiar,
        head,
        blocks,
    })
}
