//! Adam with decoupled weight decay, whose state can be kept and put back.

use anyhow::Result;
use candle_core::backprop::GradStore;
use candle_core::{Tensor, Var};

/// β₁, β₂ and ε with the defaults of Kingma & Ba 2015, Algorithm 1.
const DECAY_OF_MEAN: f64 = 0.9;
const DECAY_OF_SQUARE: f64 = 0.999;
const SMALLEST: f64 = 1e-8;

/// Adam (Kingma & Ba 2015) with decoupled weight decay (AdamW, Loshchilov & Hutter 2019).
#[derive(Debug)]
pub struct Adam {
    variables: Vec<Var>,
    weight_decay: f64,
    state: AdamState,
}

/// The optimiser's state, one tensor for each variable.
#[derive(Debug, Clone)]
pub struct AdamState {
    /// Number of steps so far.
    pub steps: usize,
    /// First moments m: running means of the gradients.
    pub means: Vec<Tensor>,
    /// Second moments v: running means of the squared gradients.
    pub squares: Vec<Tensor>,
}

impl Adam {
    /// An optimiser of these variables that has made no step yet.
    ///
    /// # Errors
    /// Candle fails.
    pub fn new(variables: Vec<Var>, weight_decay: f64) -> Result<Self> {
        let zeros = |variable: &Var| variable.zeros_like();
        let means = variables.iter().map(zeros);
        let means = means.collect::<candle_core::Result<Vec<Tensor>>>()?;
        let state = AdamState {
            steps: 0,
            squares: means.clone(),
            means,
        };
        Ok(Self {
            variables,
            weight_decay,
            state,
        })
    }

    /// The present state.
    pub fn state(&self) -> &AdamState {
        &self.state
    }

    /// Continues from a state of the same variables.
    ///
    /// # Errors
    /// Candle fails.
    pub fn resume(&mut self, state: AdamState) -> Result<()> {
        let there = |tensors: Vec<Tensor>| -> candle_core::Result<Vec<Tensor>> {
            let pairs = tensors.iter().zip(&self.variables);
            pairs.map(|(t, v)| t.to_device(v.device())).collect()
        };
        self.state = AdamState {
            steps: state.steps,
            means: there(state.means)?,
            squares: there(state.squares)?,
        };
        Ok(())
    }

    /// One step against the gradients.
    ///
    /// # Errors
    /// A gradient has another shape than its variable.
    pub fn step(&mut self, gradients: &GradStore, learning_rate: f64) -> Result<()> {
        self.state.steps += 1;
        let steps = self.state.steps as i32;
        let mean_scale = 1.0 / (1.0 - DECAY_OF_MEAN.powi(steps));
        let square_scale = 1.0 / (1.0 - DECAY_OF_SQUARE.powi(steps));
        let kept = 1.0 - learning_rate * self.weight_decay;
        let moments = self.state.means.iter_mut().zip(&mut self.state.squares);
        for (variable, (mean, square)) in self.variables.iter().zip(moments) {
            let Some(gradient) = gradients.get(variable) else {
                continue;
            };
            *mean = ((&*mean * DECAY_OF_MEAN)? + (gradient * (1.0 - DECAY_OF_MEAN))?)?;
            let gradient_sq = (gradient.sqr()? * (1.0 - DECAY_OF_SQUARE))?;
            *square = ((&*square * DECAY_OF_SQUARE)? + gradient_sq)?;
            let spread = ((&*square * square_scale)?.sqrt()? + SMALLEST)?;
            let change = ((&*mean * (mean_scale * learning_rate))? / spread)?;
            variable.set(&((variable.as_tensor() * kept)? - change)?)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use candle_core::Device;

    use super::*;

    fn value(variable: &Var) -> f32 {
        variable.as_tensor().to_vec1::<f32>().unwrap()[0]
    }

    /// Follows the slope of x² from 1.
    fn descend(adam: &mut Adam, variable: &Var, steps: usize) {
        for _ in 0..steps {
            let loss = variable.sqr().unwrap().sum_all().unwrap();
            adam.step(&loss.backward().unwrap(), 0.1).unwrap();
        }
    }

    fn one() -> Var {
        Var::new(&[1.0f32], &Device::Cpu).unwrap()
    }

    #[test]
    fn the_first_step_is_as_long_as_the_learning_rate_and_the_minimum_is_found() {
        let variable = one();
        let mut adam = Adam::new(vec![variable.clone()], 0.0).unwrap();
        descend(&mut adam, &variable, 1);
        assert!((value(&variable) - 0.9).abs() < 1e-6);
        descend(&mut adam, &variable, 300);
        assert!(value(&variable).abs() < 1e-2);
    }

    #[test]
    fn a_resumed_state_goes_on_as_if_nothing_had_been() {
        let (through, stopped) = (one(), one());
        let mut adam = Adam::new(vec![through.clone()], 0.01).unwrap();
        descend(&mut adam, &through, 7);
        let mut first = Adam::new(vec![stopped.clone()], 0.01).unwrap();
        descend(&mut first, &stopped, 4);
        let mut second = Adam::new(vec![stopped.clone()], 0.01).unwrap();
        second.resume(first.state().clone()).unwrap();
        descend(&mut second, &stopped, 3);
        assert_eq!(value(&through), value(&stopped));
    }
}
