//! Answers on clouds whose class is known.

use classifier::{ModelMetadata, Output};
use serde::Serialize;

use crate::calibration::{calibration_error, highest_probability};
use crate::metrics::Confusion;
use crate::samples::Samples;
use crate::trainer::most_probable;

/// Answers on one kind of clouds.
#[derive(Debug, Clone, Serialize)]
pub struct Test {
    /// What it was measured on.
    pub data: String,
    /// Clouds that were named.
    pub clouds: usize,
    /// Share named rightly.
    pub accuracy: f64,
    /// Right answers by class, in the order of `confusion.labels`.
    pub class_accuracies: Vec<f64>,
    /// Share called known.
    pub known_share: f64,
    /// Expected calibration error: how far probabilities are from shares of right answers.
    pub calibration_error: f64,
    /// All answers.
    pub confusion: Confusion,
}

/// One test for each way of looking at the objects: the whole surface, one view, two, ..., and standing on a box.
pub(super) fn by_view(
    data: &str,
    metadata: &ModelMetadata,
    samples: &Samples,
    answers: &[Output],
) -> Vec<Test> {
    let mut view_counts: Vec<u32> = samples.view_counts.clone();
    view_counts.sort_unstable();
    view_counts.dedup();
    let mut tests = Vec::new();
    for views in view_counts {
        let name = match views {
            0 => "whole surface".to_owned(),
            1 => "1 view".to_owned(),
            _ => format!("{views} views"),
        };
        let held = if views == 0 { 0 } else { 1 };
        let of =
            |index: &usize| samples.view_counts[*index] == views && samples.held[*index] == held;
        tests.push((name, (0..samples.len()).filter(of).collect::<Vec<_>>()));
    }
    let on_box = |index: &usize| samples.view_counts[*index] > 0 && samples.held[*index] == 0;
    tests.push((
        "on a box, without kinematics".to_owned(),
        (0..samples.len()).filter(on_box).collect(),
    ));
    tests
        .into_iter()
        .filter(|(_, indices)| !indices.is_empty())
        .map(|(name, indices)| {
            test(
                format!("{data}: {name}"),
                metadata,
                samples,
                answers,
                &indices,
            )
        })
        .collect()
}

fn test(
    data: String,
    metadata: &ModelMetadata,
    samples: &Samples,
    answers: &[Output],
    indices: &[usize],
) -> Test {
    let mut confusion = Confusion::new(&metadata.labels);
    let mut known = 0;
    let mut judged = Vec::with_capacity(indices.len());
    for &index in indices {
        let (answer, truth) = (&answers[index], samples.labels[index] as usize);
        let prediction = most_probable(&answer.log_probabilities);
        confusion.add(truth, prediction);
        known += usize::from(f64::from(answer.known_score) >= metadata.known_threshold);
        judged.push((
            highest_probability(&answer.log_probabilities),
            prediction == truth,
        ));
    }
    Test {
        data,
        clouds: indices.len(),
        accuracy: confusion.accuracy(),
        class_accuracies: confusion.class_accuracies(),
        known_share: known as f64 / indices.len() as f64,
        calibration_error: calibration_error(&judged),
        confusion,
    }
}
