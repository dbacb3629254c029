//! L-BFGS over the rotations, with the best places for each (or fixed ones).

use std::collections::VecDeque;

use nalgebra::Vector3;

use super::block::Lane;
use super::cholesky::Cholesky;
use super::energy::{Rotations, Surface};

/// Where the vertices go when the rotations are given.
pub(super) trait Places {
    /// Sets the displacements to the best ones for these rotations, or leaves them.
    fn settle(&mut self, surface: &Surface, rotations: &Rotations, moved_m: &mut [Vector3<f64>]);
}

/// Why a deformation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The energy changed by less than the settings' share in one iteration.
    EnergySettled,
    /// No step lowers the energy any more: it is least to rounding.
    NoDescent,
    /// The iterations ran out first; the energy may still be above the least.
    IterationLimit,
}

/// When to end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub energy_change_min: f64,
    pub iterations_max: usize,
}

/// Rotations, displacements, energy and its slope, which belong together.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub rotations: Rotations,
    pub moved_m: Vec<Vector3<f64>>,
    pub energy_m2: f64,
    gradient: Vec<Vector3<f64>>,
}

impl State {
    /// The source mesh, before anything was asked.
    pub fn rest(count: usize) -> Self {
        Self {
            rotations: Rotations::identity(count),
            moved_m: vec![Vector3::zeros(); count],
            energy_m2: 0.0,
            gradient: vec![Vector3::zeros(); count],
        }
    }

    /// Displacements, energy and slope for the present rotations.
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

/// Pairs of steps and changes of slope that are remembered.
const MEMORY: usize = 5;
/// A step must gain this share of what the slope promises.
const SUFFICIENT: f64 = 1e-4;
/// Times a step is shortened before it is given up.
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

/// Sets `next` to the state after the step, which is shortened until it lowers the energy enough; false if none does.
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
        // The lowest point of the parabola through what is known, within bounds.
        let lowest = -slope * length * length / (2.0 * (rise - slope * length));
        length = lowest.max(0.1 * length).min(0.5 * length);
    }
    false
}

#[derive(Default)]
struct Memory {
    pairs: VecDeque<Pair>,
    lanes: Vec<Lane>,
}

#[derive(Default)]
struct Pair {
    step: Vec<Vector3<f64>>,
    change: Vec<Vector3<f64>>,
    /// Step times change.
    curvature: f64,
}

impl Memory {
    /// Sets `step` to what would lead to the least energy if it were as curved as remembered.
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
        // Only what curves upward says where the least energy is.
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
