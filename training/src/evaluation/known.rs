//! Open-set evaluation: how well unknown objects (strangers) are told from known ones.

use serde::{Deserialize, Serialize};

/// Scores of known objects against those of strangers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Clouds of known objects.
    pub known_clouds: usize,
    /// Clouds of strangers.
    pub stranger_clouds: usize,
    /// Chance that a known object scores higher than a stranger; a half for guessing. NaN without either.
    pub auroc: f64,
    /// Share of the known objects that are called known.
    pub known_called_known: f64,
    /// Share of the strangers that are called unknown.
    pub strangers_called_unknown: f64,
}

impl Known {
    /// Compares the scores of known objects with those of strangers, each with the probability of its answer;
    /// [`classifier::is_known`] says which count as known.
    pub fn of(known: &[(f32, f64)], strangers: &[(f32, f64)], threshold: f64) -> Self {
        let called_known = |answers: &[(f32, f64)]| {
            let called = answers.iter().filter(|(score, probability)| {
                classifier::is_known(f64::from(*score), threshold, *probability)
            });
            called.count() as f64 / answers.len() as f64
        };
        let scores = |answers: &[(f32, f64)]| -> Vec<f32> {
            answers.iter().map(|(score, _)| *score).collect()
        };
        Self {
            known_clouds: known.len(),
            stranger_clouds: strangers.len(),
            auroc: auroc(&scores(known), &scores(strangers)),
            known_called_known: called_known(known),
            strangers_called_unknown: 1.0 - called_known(strangers),
        }
    }
}

/// Area under the ROC curve, computed as the Mann-Whitney statistic; ties count half.
fn auroc(positives: &[f32], negatives: &[f32]) -> f64 {
    let mut sorted = negatives.to_vec();
    sorted.sort_by(f32::total_cmp);
    let won: f64 = positives
        .iter()
        .map(|score| {
            let below = sorted.partition_point(|other| other < score);
            let not_above = sorted.partition_point(|other| other <= score);
            0.5 * (below + not_above) as f64
        })
        .sum();
    won / (positives.len() * negatives.len()) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auroc_counts_pairs_in_the_right_order() {
        let (known, strangers) = ([3.0, 1.0, 2.0], [0.0, 2.0]);
        let pairs = known.iter().flat_map(|&a| strangers.map(|b| (a, b)));
        let slow: f64 = pairs
            .map(|(a, b): (f32, f32)| {
                if a > b {
                    1.0
                } else if a == b {
                    0.5
                } else {
                    0.0
                }
            })
            .sum();
        assert_eq!(auroc(&known, &strangers), slow / 6.0);
        assert_eq!(auroc(&[1.0], &[0.0]), 1.0);
        assert!(auroc(&[], &[0.0]).is_nan());
    }

    #[test]
    fn the_threshold_itself_is_known_where_the_answer_is_certain() {
        let known = [(1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (0.0, 1.0)];
        let strangers = [(0.5, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 1.0)];
        let found = Known::of(&known, &strangers, 0.5);
        assert_eq!(
            (found.known_called_known, found.strangers_called_unknown),
            (0.5, 0.75)
        );
    }
}
