//! The methods that are compared.

use adaptation::calibration::{log_sum_exp, threshold_keeping};
use adaptation::{Block, Change, FitSettings, Head};
use anyhow::Result;
use teach::adapt::{Adapted, adapt, calibrated};
use teach::judge::{Judge, logits};
use teach::stored::Stored;

/// How an object is added to a model.
pub enum Method {
    Fit(FitSettings),
    /// With the network's own score for what is known.
    OwnScore(FitSettings),
    Prototypes,
}

impl Method {
    /// What judges answers of an adapted model.
    pub fn judge<'a>(&self, adapted: &'a Adapted) -> Judge<'a> {
        if !matches!(self, Self::OwnScore(_)) {
            return adapted.judge();
        }
        let known = adapted.blocks.iter().filter(|block| block.label.is_some());
        let scores = known.flat_map(|block| logits(&adapted.head, &block.check));
        let scores = scores.map(|logits| log_sum_exp(&logits)).collect();
        Judge {
            familiar: None,
            known_threshold: threshold_keeping(scores, 0.95),
            ..adapted.judge()
        }
    }

    pub fn adapted(&self, stored: &Stored, new: Block) -> Result<Adapted> {
        match self {
            Self::Fit(settings) | Self::OwnScore(settings) => {
                adapt(stored, new, settings, |_| true)
            }
            Self::Prototypes => prototypes(stored, new),
        }
    }
}

/// All with their names, the shipped one first.
pub fn all(shipped_only: bool) -> Vec<(&'static str, Method)> {
    let shipped = FitSettings::default();
    let fit = |change, prior| {
        Method::Fit(FitSettings {
            change,
            prior,
            ..shipped.clone()
        })
    };
    let others = [
        (
            "last layer, the network's own score",
            Method::OwnScore(shipped.clone()),
        ),
        ("last layer, weak prior", fit(Change::Last, 1e-3)),
        ("both layers", fit(Change::Both, 1e-1)),
        ("both layers, weak prior", fit(Change::Both, 1e-2)),
        ("a prototype for each class", Method::Prototypes),
    ];
    let mut all = vec![("last layer", Method::Fit(shipped.clone()))];
    if !shipped_only {
        all.extend(others);
    }
    all
}

/// A mean of hidden values for each class; a cloud belongs to the nearest, by the spread within classes.
fn prototypes(stored: &Stored, new: Block) -> Result<Adapted> {
    let mut blocks = stored.kept.blocks.clone();
    let strangers = blocks.pop();
    blocks.push(new);
    let hidden = blocks
        .iter()
        .map(|block| stored.head.hidden_of(&block.fit.matrix()));
    let hidden: Vec<_> = hidden.collect();
    let means: Vec<_> = hidden.iter().map(|rows| rows.row_mean()).collect();
    let squares = hidden.iter().zip(&means).map(|(rows, mean)| {
        let squares = rows.row_iter().map(|row| (row - mean).norm_squared());
        squares.sum::<f64>() / rows.nrows() as f64
    });
    let width = stored.head.hidden.bias.len();
    let variance = squares.sum::<f64>() / (blocks.len() * width) as f64;
    let mut head: Head = stored.head.with_class();
    for (class, mean) in means.iter().enumerate() {
        head.last
            .weight
            .set_column(class, &(mean.transpose() / variance));
        head.last.bias[class] = -0.5 * mean.norm_squared() / variance;
    }
    blocks.extend(strangers);
    calibrated(stored, head, blocks)
}

/// The model with its new layers, without files.
pub fn after(mut stored: Stored, adapted: Adapted) -> Stored {
    let labels = adapted
        .blocks
        .iter()
        .filter_map(|block| block.label.clone());
    stored.metadata.labels = labels.collect();
    stored.head = adapted.head;
    stored.familiar = Some(adapted.familiar);
    stored.inverse_temperature = adapted.inverse_temperature;
    stored.metadata.known_threshold = adapted.known_threshold;
    stored.kept.blocks = adapted.blocks;
    stored
}
