//! How well a model tells an object, and what it takes for another.

use adaptation::calibration::log_sum_exp;
use adaptation::{Familiar, FeatureRows, Head};
use classifier::is_known;
use serde::Serialize;

use crate::history::HeldOut;

/// A model's answer about one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Probabilities of the classes.
    pub probabilities: Vec<f64>,
    /// The most probable one.
    pub best: usize,
    /// Whether it is called known.
    pub known: bool,
    /// The known score.
    pub score: f64,
}

/// Layers with what their answers are judged by.
#[derive(Debug, Clone, Copy)]
pub struct Judge<'a> {
    /// The layers.
    pub head: &'a Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// What gives the known score; the layers themselves without it.
    pub familiar: Option<&'a Familiar>,
    /// Threshold of the known score.
    pub known_threshold: f64,
}

impl Judge<'_> {
    /// The answer about a cloud of one or more samples, as the classifier gives it.
    pub fn judge(&self, samples: &FeatureRows) -> Judged {
        let logits = logits(self.head, samples);
        let count = logits.len().max(1) as f64;
        let mut probabilities = vec![0.0; self.head.classes()];
        for row in &logits {
            let scaled: Vec<f32> = row
                .iter()
                .map(|logit| self.inverse_temperature as f32 * logit)
                .collect();
            let sum = log_sum_exp(&scaled);
            for (total, logit) in probabilities.iter_mut().zip(&scaled) {
                *total += (f64::from(*logit) - sum).exp() / count;
            }
        }
        let score = match self.familiar {
            Some(familiar) => familiar.score(samples),
            None => logits.iter().map(|row| log_sum_exp(row)).sum::<f64>() / count,
        };
        let best = (0..probabilities.len())
            .max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]))
            .unwrap_or(0);
        let probability = probabilities.get(best).copied().unwrap_or(0.0);
        Judged {
            best,
            known: is_known(score, self.known_threshold, probability),
            probabilities,
            score,
        }
    }

    /// The answer about each cloud of one sample.
    pub fn judge_each(&self, rows: &FeatureRows) -> Vec<Judged> {
        rows.parts(1).map(|row| self.judge(&row)).collect()
    }
}

/// Logits of each row.
pub fn logits(head: &Head, rows: &FeatureRows) -> Vec<Vec<f32>> {
    let logits = head.logits(&rows.matrix());
    let row = |row: nalgebra::RowDVector<f64>| row.iter().map(|&value| value as f32).collect();
    logits
        .row_iter()
        .map(|view| row(view.into_owned()))
        .collect()
}

/// How often a class is named.
pub fn held_out(answers: &[Judged], class: usize) -> HeldOut {
    let share = |is_meant: &dyn Fn(&Judged) -> bool| {
        let count = answers.iter().filter(|answer| is_meant(answer)).count();
        count as f64 / answers.len().max(1) as f64
    };
    HeldOut {
        scans: answers.len(),
        right: share(&|answer| answer.best == class),
        known_and_right: share(&|answer| answer.best == class && answer.known),
    }
}

/// Another object that is taken for the new one, or the new one for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Twin {
    /// Its label.
    pub label: String,
    /// Share of the clouds of both, half and half, in which the right one of the two is the more probable.
    pub told_apart: f64,
    /// How much larger the new one is, in width and height, m; `None` where there is no reference of the other.
    pub larger_m: Option<[f64; 2]>,
}

/// Pairs that are told apart less often than this are said.
const TWIN_MAX: f64 = 0.98;

/// Share of two classes' clouds, half and half, in which the right one of the two is the more probable.
pub fn told_apart(a: (usize, &[Judged]), b: (usize, &[Judged])) -> f64 {
    let share = |(own, answers): (usize, &[Judged]), other: usize| {
        let right = answers.iter().filter(|answer| {
            let p = &answer.probabilities;
            p[own] > p[other]
        });
        right.count() as f64 / answers.len().max(1) as f64
    };
    0.5 * (share(a, b.0) + share(b, a.0))
}

impl Twin {
    /// A twin, if these two are told apart seldom enough.
    pub fn of(label: &str, told_apart: f64, larger_m: Option<[f64; 2]>) -> Option<Self> {
        (told_apart < TWIN_MAX).then(|| Self {
            label: label.to_owned(),
            told_apart,
            larger_m,
        })
    }

    /// In words, beside the name of the new object.
    pub fn to_text(&self, new: &str) -> String {
        let differ = self.larger_m.map(|[width_m, height_m]| {
            let said = |metres: f64, what| {
                let mm = (1e3 * metres.abs()).round();
                (mm >= 1.0).then(|| format!("{mm} mm in {what}"))
            };
            let parts: Vec<String> = [said(width_m, "width"), said(height_m, "height")]
                .into_iter()
                .flatten()
                .collect();
            match parts.as_slice() {
                [] => "have the same width and height to a millimetre".to_owned(),
                parts => format!("differ by {}", parts.join(" and ")),
            }
        });
        format!(
            "{new} and {} {}; told apart in {:.0} % of held-out views",
            self.label,
            differ.unwrap_or_else(|| "are alike".to_owned()),
            100.0 * self.told_apart
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(probabilities: [f64; 3]) -> Judged {
        let best = (0..3).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
        Judged {
            best: best.unwrap_or(0),
            probabilities: probabilities.to_vec(),
            known: true,
            score: 1.0,
        }
    }

    #[test]
    fn a_pair_is_judged_by_the_two_alone() {
        let new = [answer([0.1, 0.2, 0.7]), answer([0.0, 0.6, 0.4])];
        let old = [answer([0.5, 0.4, 0.1]), answer([0.2, 0.5, 0.3])];
        assert_eq!(told_apart((2, &new), (1, &old)), 0.75);
        assert_eq!(held_out(&new, 2).right, 0.5);
        assert_eq!(held_out(&[], 2).right, 0.0);
    }

    #[test]
    fn twins_are_said_in_words() {
        assert_eq!(Twin::of("can", 0.99, None), None);
        let said = |larger_m| Twin::of("can", 0.913, larger_m).map(|twin| twin.to_text("mine"));
        let text = |differ| {
            Some(format!(
                "mine and can {differ}; told apart in 91 % of held-out views"
            ))
        };
        assert_eq!(said(None), text("are alike"));
        assert_eq!(said(Some([0.0, -0.0021])), text("differ by 2 mm in height"));
        assert_eq!(
            said(Some([0.0101, 0.003])),
            text("differ by 10 mm in width and 3 mm in height")
        );
        assert_eq!(
            said(Some([0.0001, 0.0])),
            text("have the same width and height to a millimetre")
        );
    }
}
