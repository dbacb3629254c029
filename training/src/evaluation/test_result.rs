//! Accuracy, loss and calibration of answers about labelled clouds.

use serde::{Deserialize, Serialize};

use crate::evaluation::calibration::{calibration_error, highest_probability};
use crate::evaluation::confusion::Confusion;
use crate::training::tally::most_probable;

/// Result on clouds that had no part in training.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct TestResult {
    /// Number of clouds.
    pub clouds: usize,
    /// Share of right answers.
    pub accuracy: f64,
    /// Share of right answers for each class, in the order of `confusion.labels`.
    pub class_accuracies: Vec<f64>,
    /// Mean negative log-likelihood.
    pub loss: f64,
    /// Share of the clouds called known.
    pub known_share: f64,
    /// Share of the clouds called known and named wrongly.
    pub known_wrong_share: f64,
    /// Expected calibration error, 0 to 1 (see [`super::calibration::calibration_error`]).
    pub calibration_error: f64,
    /// All answers, counted by class.
    pub confusion: Confusion,
}

/// One answer and the truth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answered<'a> {
    /// `[C]` log-probabilities of the classes.
    pub log_probabilities: &'a [f32],
    /// Negative energy: how much the cloud is like the known classes.
    pub known_score: f64,
    /// Index of the true class.
    pub label: usize,
}

impl TestResult {
    /// Evaluates answers of a model with these labels. A score of at least the threshold counts as known.
    pub(crate) fn of<'a>(
        labels: &[String],
        known_threshold: f64,
        answers: impl Iterator<Item = Answered<'a>>,
    ) -> Self {
        let mut confusion = Confusion::new(labels);
        let (mut known, mut known_wrong, mut loss, mut judged) = (0, 0, 0.0, Vec::new());
        for answer in answers {
            let prediction = most_probable(answer.log_probabilities);
            let probability = highest_probability(answer.log_probabilities);
            let right = prediction == answer.label;
            confusion.add(answer.label, prediction);
            if classifier::is_known(answer.known_score, known_threshold, probability) {
                known += 1;
                known_wrong += usize::from(!right);
            }
            loss -= f64::from(answer.log_probabilities[answer.label]);
            judged.push((probability, right));
        }
        let count = judged.len().max(1) as f64;
        Self {
            clouds: judged.len(),
            accuracy: confusion.accuracy(),
            class_accuracies: confusion.class_accuracies(),
            loss: loss / count,
            known_share: known as f64 / count,
            known_wrong_share: known_wrong as f64 / count,
            calibration_error: calibration_error(&judged),
            confusion,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_counted_once_each() {
        let half = 0.5f32.ln();
        let answered = |log_probabilities, known_score, label| Answered {
            log_probabilities,
            known_score,
            label,
        };
        let (sure, unsure) = ([0.0, f32::NEG_INFINITY], [half + 1e-6, half]);
        let answers = [
            // Not known, since it is like either.
            answered(&unsure, 2.0, 0),
            answered(&sure, 2.0, 0),
            answered(&sure, 1.0, 0),
            answered(&unsure, 0.0, 1),
            answered(&unsure, 0.5, 0),
        ];
        let labels = ["a".to_owned(), "b".to_owned()];
        let test = TestResult::of(&labels, 1.0, answers.into_iter());
        assert_eq!((test.clouds, test.accuracy), (5, 0.8));
        assert_eq!(test.class_accuracies, [1.0, 0.0]);
        assert_eq!((test.known_share, test.known_wrong_share), (0.4, 0.0));
        assert!((test.loss - 0.6 * std::f64::consts::LN_2).abs() < 1e-5);
        // Of three answers with a probability of 1/2, two are right: 3/5 of |2/3 - 1/2|.
        assert!(
            (test.calibration_error - 0.1).abs() < 1e-5,
            "{}",
            test.calibration_error
        );
    }
}
