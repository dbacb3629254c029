//! L-BFGS (Nocedal and Wright, Numerical Optimization, 2nd ed., Alg. 7.4 and 7.5) with Armijo's rule.

use std::collections::VecDeque;

use nalgebra::DVector;

/// Pairs of steps and changes of the gradient that are remembered.
const MEMORY: usize = 12;
/// Share of the fall that the slope promises, which a step must bring (Armijo).
const FALL_MIN: f64 = 1e-4;
/// Halvings of a step before the search gives up.
const HALVINGS: usize = 30;

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stop {
    /// The gradient's largest component, below which the minimum is reached.
    pub gradient_max: f64,
    /// Most steps.
    pub steps: usize,
}

/// Goes down from `start`; `value_and_gradient` is smooth. Ends early where `go_on` says no.
///
/// Gives the lowest point that was found.
pub(crate) fn minimise(
    start: DVector<f64>,
    stop: Stop,
    mut value_and_gradient: impl FnMut(&DVector<f64>) -> (f64, DVector<f64>),
    mut go_on: impl FnMut(usize) -> bool,
) -> DVector<f64> {
    let mut at = start;
    let (mut value, mut gradient) = value_and_gradient(&at);
    let mut memory: VecDeque<Pair> = VecDeque::with_capacity(MEMORY);
    for step in 0..stop.steps {
        if gradient.amax() <= stop.gradient_max || !go_on(step) {
            break;
        }
        let mut direction = -bent(&gradient, &memory);
        let mut slope = direction.dot(&gradient);
        if slope >= 0.0 {
            memory.clear();
            direction = -&gradient;
            slope = -gradient.norm_squared();
        }
        // Without memory the gradient's length says nothing about the step's.
        let mut length = if memory.is_empty() {
            (1.0 / gradient.norm()).min(1.0)
        } else {
            1.0
        };
        let mut found = None;
        for _ in 0..HALVINGS {
            let next = &at + length * &direction;
            let (next_value, next_gradient) = value_and_gradient(&next);
            if next_value <= value + FALL_MIN * length * slope {
                found = Some((next, next_value, next_gradient));
                break;
            }
            length *= 0.5;
        }
        let Some((next, next_value, next_gradient)) = found else {
            // Rounding: no step goes down any more.
            break;
        };
        let pair = Pair::new(&next - &at, &next_gradient - &gradient);
        if let Some(pair) = pair {
            if memory.len() == MEMORY {
                memory.pop_front();
            }
            memory.push_back(pair);
        }
        (at, value, gradient) = (next, next_value, next_gradient);
    }
    at
}

/// A step and the change of the gradient over it.
struct Pair {
    step: DVector<f64>,
    change: DVector<f64>,
    inverse_product: f64,
}

impl Pair {
    /// `None` where the function is not curved upward along the step.
    fn new(step: DVector<f64>, change: DVector<f64>) -> Option<Self> {
        let product = step.dot(&change);
        let is_curved = product > 1e-12 * step.norm() * change.norm();
        is_curved.then(|| Self {
            step,
            change,
            inverse_product: 1.0 / product,
        })
    }
}

/// The gradient times the inverse Hessian as the memory knows it.
fn bent(gradient: &DVector<f64>, memory: &VecDeque<Pair>) -> DVector<f64> {
    let mut direction = gradient.clone();
    let mut shares = Vec::with_capacity(memory.len());
    for pair in memory.iter().rev() {
        let share = pair.inverse_product * pair.step.dot(&direction);
        direction.axpy(-share, &pair.change, 1.0);
        shares.push(share);
    }
    if let Some(last) = memory.back() {
        direction *= 1.0 / (last.inverse_product * last.change.norm_squared());
    }
    for (pair, share) in memory.iter().zip(shares.into_iter().rev()) {
        let back = pair.inverse_product * pair.change.dot(&direction);
        direction.axpy(share - back, &pair.step, 1.0);
    }
    direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_valley_of_rosenbrock_is_followed_to_its_end() {
        let value_and_gradient = |at: &DVector<f64>| {
            let (x, y) = (at[0], at[1]);
            let off = y - x * x;
            let value = (1.0 - x).powi(2) + 100.0 * off * off;
            let gradient = vec![-2.0 * (1.0 - x) - 400.0 * x * off, 200.0 * off];
            (value, DVector::from_vec(gradient))
        };
        let stop = Stop {
            gradient_max: 1e-9,
            steps: 200,
        };
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let found = minimise(start, stop, value_and_gradient, |_| true);
        assert!(
            (found[0] - 1.0).abs() < 1e-6 && (found[1] - 1.0).abs() < 1e-6,
            "{found}"
        );
    }

    #[test]
    fn it_ends_where_it_is_told_to() {
        let square = |at: &DVector<f64>| (at.norm_squared(), 2.0 * at);
        let stop = Stop {
            gradient_max: 0.0,
            steps: 100,
        };
        let start = DVector::from_element(3, 5.0);
        let found = minimise(start.clone(), stop, square, |_| false);
        assert_eq!(found, start);
    }
}
