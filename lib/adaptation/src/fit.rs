//! Fits the layers after the features.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::head::{Head, Layer};
use crate::kept::FeatureRows;
use crate::minimise::{Stop, minimise};

/// Rows of features that are computed together.
const BLOCK: usize = 256;

/// Which layers may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The last one: multinomial logistic regression, which has one minimum.
    Last,
    /// Both.
    Both,
}

/// How the layers are fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FitSettings {
    /// Which layers may change.
    pub change: Change,
    /// Weight of the squared distance from the layers of before, against the mean loss of a cloud: a normal prior about
    /// them. They were fitted to many more clouds than are kept.
    pub prior: f64,
    /// The same of the last class, which is new, about nothing.
    pub prior_of_new: f64,
    /// Weight of the strangers against that of a class.
    pub strangers_weight: f64,
    /// Most steps of the optimisation.
    pub steps: usize,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            change: Change::Last,
            prior: 1e-1,
            prior_of_new: 1e-3,
            strangers_weight: 1.0,
            steps: 200,
        }
    }
}

/// Fits the layers to features of each class, the last of which is new, and of strangers. Classes count alike, however many clouds they have. The
/// same arguments give the same layers, whatever the number of threads. Ends early where `go_on` says no.
///
/// The loss is the cross-entropy of softmax(logits, 0), where the 0 stands for "none of the classes", as in training.
///
/// # Panics
/// If there is not one list of features for each class of the head, of as many values as it takes.
pub fn fit(
    head: &Head,
    classes: &[FeatureRows],
    strangers: &FeatureRows,
    settings: &FitSettings,
    go_on: impl FnMut(usize) -> bool,
) -> Head {
    let problem = Problem::new(head, classes, strangers, settings);
    let stop = Stop {
        gradient_max: 1e-7,
        steps: settings.steps,
    };
    let found = minimise(problem.start.clone(), stop, |at| problem.loss(at), go_on);
    problem.head_at(&found)
}

struct Problem {
    before: Head,
    change: Change,
    /// Weight of each parameter's squared distance from what it was.
    prior: DVector<f64>,
    /// The parameters that may change, as they were.
    start: DVector<f64>,
    blocks: Vec<Samples>,
}

/// Some clouds: what the first layer that changes takes of each, and its class; the number of classes stands for none.
struct Samples {
    inputs: DMatrix<f64>,
    transposed: DMatrix<f64>,
    labels: Vec<usize>,
    weights: Vec<f64>,
}

impl Problem {
    fn new(
        head: &Head,
        classes: &[FeatureRows],
        strangers: &FeatureRows,
        settings: &FitSettings,
    ) -> Self {
        assert_eq!(classes.len(), head.classes(), "features of each class");
        let all: Vec<(usize, &FeatureRows, f64)> = classes
            .iter()
            .enumerate()
            .map(|(label, rows)| (label, rows, 1.0))
            .chain([(classes.len(), strangers, settings.strangers_weight)])
            .collect();
        let total: f64 = all
            .iter()
            .filter(|(_, rows, _)| !rows.is_empty())
            .map(|s| s.2)
            .sum();
        let mut blocks = Vec::new();
        for (label, rows, weight) in all {
            let each = weight / (total * rows.len().max(1) as f64);
            for part in rows.parts(BLOCK) {
                let features = part.matrix();
                let inputs = match settings.change {
                    Change::Last => head.hidden_of(&features),
                    Change::Both => features,
                };
                blocks.push(Samples {
                    transposed: inputs.transpose(),
                    labels: vec![label; inputs.nrows()],
                    weights: vec![each; inputs.nrows()],
                    inputs,
                });
            }
        }
        let mut start = Vec::new();
        if settings.change == Change::Both {
            start.extend(head.hidden.weight.iter().chain(head.hidden.bias.iter()));
        }
        start.extend(head.last.weight.iter().chain(head.last.bias.iter()));
        let mut prior = DVector::from_element(start.len(), settings.prior);
        // Column by column, and the bias last.
        let (rows, classes) = head.last.weight.shape();
        let last = start.len() - (rows + 1) * classes;
        let of_new = last + rows * (classes - 1)..last + rows * classes;
        of_new
            .chain([start.len() - 1])
            .for_each(|index| prior[index] = settings.prior_of_new);
        Self {
            before: head.clone(),
            change: settings.change,
            prior,
            start: DVector::from_vec(start),
            blocks,
        }
    }

    /// The layers with these parameters.
    fn head_at(&self, at: &DVector<f64>) -> Head {
        let mut values = at.iter().copied();
        let mut layer = |before: &Layer| {
            let (inputs, outputs) = before.weight.shape();
            let weight =
                DMatrix::from_iterator(inputs, outputs, values.by_ref().take(inputs * outputs));
            let bias = DVector::from_iterator(outputs, values.by_ref().take(outputs));
            Layer { weight, bias }
        };
        Head {
            hidden: match self.change {
                Change::Last => self.before.hidden.clone(),
                Change::Both => layer(&self.before.hidden),
            },
            last: layer(&self.before.last),
        }
    }

    /// Loss and its gradient.
    fn loss(&self, at: &DVector<f64>) -> (f64, DVector<f64>) {
        let head = self.head_at(at);
        let parts: Vec<(f64, DVector<f64>)> = self
            .blocks
            .par_iter()
            .map(|samples| self.loss_of(samples, &head))
            .collect();
        let off = at - &self.start;
        let mut gradient = self.prior.component_mul(&off);
        let mut loss = 0.5 * gradient.dot(&off);
        // Summed in a fixed order, so that the result does not depend on the number of threads.
        for (part, slope) in parts {
            loss += part;
            gradient += slope;
        }
        (loss, gradient)
    }

    fn loss_of(&self, samples: &Samples, head: &Head) -> (f64, DVector<f64>) {
        let hidden = match self.change {
            Change::Last => None,
            Change::Both => Some(head.hidden_of(&samples.inputs)),
        };
        let last_inputs = hidden.as_ref().unwrap_or(&samples.inputs);
        let mut slopes = head.last.of(last_inputs);
        let loss = to_slopes(&mut slopes, samples);
        let mut gradient = Vec::with_capacity(self.start.len());
        match &hidden {
            None => push_gradient(&mut gradient, &samples.transposed, &slopes),
            Some(hidden) => {
                let mut back = &slopes * head.last.weight.transpose();
                back.zip_apply(hidden, |slope, value| {
                    if value <= 0.0 {
                        *slope = 0.0;
                    }
                });
                push_gradient(&mut gradient, &samples.transposed, &back);
                push_gradient(&mut gradient, &hidden.transpose(), &slopes);
            }
        }
        (loss, DVector::from_vec(gradient))
    }
}

/// Turns logits into the slopes of the weighted loss with respect to them; gives the loss.
fn to_slopes(logits: &mut DMatrix<f64>, samples: &Samples) -> f64 {
    let mut loss = 0.0;
    let classes = logits.ncols();
    for (row, (&label, &weight)) in samples.labels.iter().zip(&samples.weights).enumerate() {
        let mut values = logits.row_mut(row);
        // The logit of "none of them" is 0.
        let highest = values.iter().copied().fold(0.0, f64::max);
        let own = if label < classes { values[label] } else { 0.0 };
        let sum = values.iter().map(|v| (v - highest).exp()).sum::<f64>() + (-highest).exp();
        loss += weight * (highest + sum.ln() - own);
        values.apply(|value| *value = weight * (*value - highest).exp() / sum);
        if label < classes {
            values[label] -= weight;
        }
    }
    loss
}

/// The gradient of a layer's weight and bias, from its inputs `[I, M]` and the slopes `[M, O]` at its outputs.
fn push_gradient(gradient: &mut Vec<f64>, inputs: &DMatrix<f64>, slopes: &DMatrix<f64>) {
    gradient.extend((inputs * slopes).iter());
    gradient.extend(slopes.row_sum().iter());
}

#[cfg(test)]
mod tests;
