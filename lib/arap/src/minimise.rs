//! Preconditioned L-BFGS over the rotations (Nocedal and Wright, Numerical Optimization, Sec. 7.2). The vertex positions
//! are not unknowns: for given rotations they follow from ARAP's global step, a linear solve, or stay fixed.

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::block::Lane;
use super::cholesky::Cholesky;
use super::energy::{Rotations, Surface};

/// ARAP's global step: vertex positions for given rotations.
pub(super) trait Places {
    /// Sets the displacements to the ones of least energy for these rotations, or to fixed ones.
    fn settle(&mut self, surface: &Surface, rotations: &Rotations, moved_m: &mut [Vector3<f64>]);
}

/// Why a deformation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The energy changed by less than the settings' share in one iteration.
    EnergySettled,
    /// The line search found no lower energy: it is at its minimum to rounding.
    NoDescent,
    /// The limit of iterations was reached first; the energy may still be above its minimum.
    IterationLimit,
}

/// When to end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub energy_change_min: f64,
    pub iterations_max: usize,
}

/// An iterate: rotations with the displacements, energy and gradient that follow from them.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub rotations: Rotations,
    pub moved_m: Vec<Vector3<f64>>,
    pub energy_m2: f64,
    gradient: Vec<Vector3<f64>>,
}

impl State {
    /// The undeformed source mesh.
    pub fn rest(count: usize) -> Self {
        Self {
            rotations: Rotations::identity(count),
            moved_m: vec![Vector3::zeros(); count],
            energy_m2: 0.0,
            gradient: vec![Vector3::zeros(); count],
        }
    }

    /// Computes displacements, energy and gradient for the present rotations.
    fn evaluate(&mut self, surface: &Surface, places: &mut impl Places) {
        places.settle(surface, &self.rotations, &mut self.moved_m);
        self.energy_m2 = surface.energy(&self.rotations, &self.moved_m, &mut self.gradient);
    }
}

/// How a minimisation went.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub stop: Stop,
    /// Energy at the start and after each iteration.
    pub energies_m2: Vec<f64>,
}

/// Pairs of step s and gradient change y that L-BFGS keeps (m of Nocedal and Wright, who suggest 3 to 20).
const MEMORY: usize = 5;
/// c₁ of the Armijo condition: a step must gain this share of what the gradient promises (Nocedal and Wright, Eq. 3.4).
const SUFFICIENT: f64 = 1e-4;
/// Backtracking: how often the line search shortens a step before it gives up.
const SHORTENINGS: usize = 12;

/// Lowers the energy from the state's rotations until it settles. It never rises from one iteration to the next.
pub(super) fn minimise(
    surface: &Surface,
    preconditioner: &Cholesky,
    places: &mut impl Places,
    state: &mut State,
    limits: Limits,
) -> Outcome {
    state.evaluate(surface, places);
    let mut energies_m2 = vec![state.energy_m2];
    let mut next = State::rest(state.moved_m.len());
    let mut memory = Memory::default();
    let mut step = vec![Vector3::zeros(); state.moved_m.len()];
    let stop = loop {
        if energies_m2.len() > limits.iterations_max {
            break Stop::IterationLimit;
        }
        memory.step(&state.gradient, preconditioner, &mut step);
        let mut lower = search(surface, places, state, &mut next, &mut step);
        if !lower && !memory.pairs.is_empty() {
            memory.pairs.clear();
            memory.step(&state.gradient, preconditioner, &mut step);
            lower = search(surface, places, state, &mut next, &mut step);
        }
        if !lower {
            break Stop::NoDescent;
        }
        let change = state.energy_m2 - next.energy_m2;
        memory.learn(&step, &state.gradient, &next.gradient);
        std::mem::swap(state, &mut next);
        energies_m2.push(state.energy_m2);
        if change <= limits.energy_change_min * state.energy_m2 {
            break Stop::EnergySettled;
        }
    };
    Outcome { stop, energies_m2 }
}

/// Backtracking line search: shortens `step` until it fulfils the Armijo condition and sets `next` to the state after it.
/// Returns false if no length does, or if `step` does not descend.
fn search(
    surface: &Surface,
    places: &mut impl Places,
    state: &State,
    next: &mut State,
    step: &mut [Vector3<f64>],
) -> bool {
    let slope = dot(step, &state.gradient);
    if slope.is_nan() || slope >= 0.0 {
        return false;
    }
    let mut length = 1.0;
    for _ in 0..SHORTENINGS {
        next.rotations.set_turned(&state.rotations, step, length);
        next.evaluate(surface, places);
        let rise = next.energy_m2 - state.energy_m2;
        if rise <= SUFFICIENT * length * slope {
            step.iter_mut().for_each(|turn| *turn *= length);
            return true;
        }
        // Minimum of the parabola through both energies and the slope, within bounds.
        let lowest = -slope * length * length / (2.0 * (rise - slope * length));
        length = lowest.max(0.1 * length).min(0.5 * length);
    }
    false
}

/// The last steps and gradient changes, from which L-BFGS approximates the inverse Hessian.
#[derive(Default)]
struct Memory {
    pairs: VecDeque<Pair>,
    lanes: Vec<Lane>,
}

#[derive(Default)]
struct Pair {
    /// s: the rotations' change in one iteration.
    step: Vec<Vector3<f64>>,
    /// y: the gradient's change in it.
    change: Vec<Vector3<f64>>,
    /// s·y, positive.
    curvature: f64,
}

impl Memory {
    /// L-BFGS two-loop recursion (Nocedal and Wright, Algorithm 7.4): `step` becomes the quasi-Newton direction −H·gradient.
    /// The initial inverse Hessian is the preconditioner's.
    fn step(
        &mut self,
        gradient: &[Vector3<f64>],
        preconditioner: &Cholesky,
        step: &mut [Vector3<f64>],
    ) {
        for (step, slope) in step.iter_mut().zip(gradient) {
            *step = -slope;
        }
        let mut shares = [0.0; MEMORY];
        for (pair, share) in self.pairs.iter().zip(&mut shares).rev() {
            *share = dot(&pair.step, step) / pair.curvature;
            add(step, -*share, &pair.change);
        }
        self.precondition(preconditioner, step);
        for (pair, share) in self.pairs.iter().zip(shares) {
            let back = dot(&pair.change, step) / pair.curvature;
            add(step, share - back, &pair.step);
        }
    }

    fn precondition(&mut self, preconditioner: &Cholesky, step: &mut [Vector3<f64>]) {
        self.lanes.clear();
        self.lanes
            .extend(step.iter().map(|turn| [turn.x, turn.y, turn.z, 0.0]));
        preconditioner.solve_lower(&mut self.lanes);
        preconditioner.solve_upper(&mut self.lanes);
        for (turn, lane) in step.iter_mut().zip(&self.lanes) {
            *turn = Vector3::new(lane[0], lane[1], lane[2]);
        }
    }

    /// Adds an iteration's step and gradient change, in place of the oldest pair if the memory is full.
    fn learn(&mut self, step: &[Vector3<f64>], before: &[Vector3<f64>], after: &[Vector3<f64>]) {
        let oldest = if self.pairs.len() < MEMORY {
            None
        } else {
            self.pairs.pop_front()
        };
        let mut pair = oldest.unwrap_or_default();
        pair.step.clear();
        pair.step.extend_from_slice(step);
        pair.change.clear();
        pair.change.extend(
            after
                .iter()
                .zip(before)
                .map(|(after, before)| after - before),
        );
        pair.curvature = dot(step, &pair.change);
        // Curvature condition s·y > 0: it keeps the approximate Hessian positive definite.
        let least = 1e-10 * (dot(&pair.change, &pair.change) * dot(step, step)).sqrt();
        if pair.curvature > least {
            self.pairs.push_back(pair);
        }
    }
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

fn add(sum: &mut [Vector3<f64>], factor: f64, other: &[Vector3<f64>]) {
    for (sum, other) in sum.iter_mut().zip(other) {
        *sum += other * factor;
    }
}
