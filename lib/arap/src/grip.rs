//! Deforming with one set of handles.

use nalgebra::{Point3, Vector3};

use super::energy::Rotations;
use super::error::ArapError;
use super::handles::Handles;
use super::minimise::{State, Stop, minimise};
use super::source::{Arap, marked};

/// A source mesh with a set of handles to move. Each deformation starts from the one before (warm start).
#[derive(Debug, Clone)]
pub struct Grip<'a> {
    arap: &'a Arap,
    pub(super) handles: Handles<'a>,
    pub(super) state: State,
    /// The handles' displacements and the rotations of the deformation before the last, to extrapolate from.
    before: Option<(Vec<Vector3<f64>>, Rotations)>,
}

/// A deformed mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Deformed {
    /// Positions of all vertices, in the mesh's order.
    pub vertices_m: Vec<Point3<f64>>,
    /// Energy (Eq. 3) in square metres.
    pub energy_m2: f64,
    /// Energy at the start and after each iteration.
    pub energies_m2: Vec<f64>,
    /// Number of L-BFGS iterations.
    pub iterations: usize,
    /// Why the iterations ended.
    pub stop: Stop,
}

impl Arap {
    /// Prepares moving these vertices: solves once for the response of each and inverts their joint system.
    ///
    /// # Errors
    /// [`ArapError::NoSuchVertex`], [`ArapError::Repeated`] and [`ArapError::HeldHandle`] for unfit handles,
    /// [`ArapError::Unconstrained`] where a component has neither a handle nor a held vertex, and
    /// [`ArapError::Singular`] where the handles leave no unique solution.
    pub fn grip(&self, handles: &[u32]) -> Result<Grip<'_>, ArapError> {
        marked(handles, self.order.len(), "a handle")?;
        let vertices: Vec<usize> = handles
            .iter()
            .map(|&handle| self.places[handle as usize])
            .collect();
        if let Some(index) = vertices.iter().position(|&vertex| self.held[vertex]) {
            return Err(ArapError::HeldHandle {
                vertex: handles[index],
            });
        }
        self.check_constrained(&vertices)?;
        let handles = Handles::new(&self.system, vertices).ok_or_else(|| ArapError::Singular {
            system: "handles",
            cause: "no inverse".into(),
        })?;
        Ok(Grip {
            arap: self,
            handles,
            state: State::rest(self.order.len()),
            before: None,
        })
    }

    /// Each component needs a held vertex or a handle.
    fn check_constrained(&self, handles: &[usize]) -> Result<(), ArapError> {
        let mut tied = vec![false; self.order.len()];
        let held = (0..self.order.len()).filter(|&vertex| self.held[vertex]);
        held.chain(handles.iter().copied())
            .for_each(|vertex| tied[self.components[vertex] as usize] = true);
        let Some(&loose) = self
            .components
            .iter()
            .find(|&&component| !tied[component as usize])
        else {
            return Ok(());
        };
        let members = || (0..self.order.len()).filter(|&vertex| self.components[vertex] == loose);
        Err(ArapError::Unconstrained {
            vertex: members()
                .map(|vertex| self.order[vertex])
                .min()
                .unwrap_or_default() as u32,
            size: members().count(),
        })
    }
}

impl Grip<'_> {
    /// Moves the handles to `targets_m`, one each, in their order. Starts from this grip's last deformation.
    ///
    /// # Errors
    /// [`ArapError::TargetCount`], or [`ArapError::Target`] for one that is not finite or out of reach.
    pub fn deform(&mut self, targets_m: &[Point3<f64>]) -> Result<Deformed, ArapError> {
        let moves_m = self.moves_m(targets_m)?;
        let last = (
            std::mem::replace(&mut self.handles.moves_m, moves_m),
            self.state.rotations.clone(),
        );
        self.extrapolate(&last.0);
        self.before = Some(last);
        let arap = self.arap;
        let outcome = minimise(
            &arap.surface,
            &arap.preconditioner,
            &mut self.handles,
            &mut self.state,
            arap.limits,
        );
        let place =
            |&place: &usize| Point3::from(arap.surface.rest_m[place] + self.state.moved_m[place]);
        Ok(Deformed {
            vertices_m: arap.places.iter().map(place).collect(),
            energy_m2: self.state.energy_m2,
            iterations: outcome.energies_m2.len() - 1,
            energies_m2: outcome.energies_m2,
            stop: outcome.stop,
        })
    }

    fn moves_m(&self, targets_m: &[Point3<f64>]) -> Result<Vec<Vector3<f64>>, ArapError> {
        if targets_m.len() != self.handles.vertices.len() {
            return Err(ArapError::TargetCount {
                targets: targets_m.len(),
                handles: self.handles.vertices.len(),
            });
        }
        let moves = targets_m.iter().zip(&self.handles.vertices);
        let moves_m: Vec<_> = moves
            .map(|(target, &vertex)| target.coords - self.arap.surface.rest_m[vertex])
            .collect();
        match moves_m
            .iter()
            .position(|way| way.norm().is_nan() || way.norm() > self.arap.reach_m)
        {
            None => Ok(moves_m),
            Some(index) => Err(ArapError::Target {
                index,
                target: targets_m[index],
                limit_m: self.arap.reach_m,
            }),
        }
    }

    /// Initial guess: if the handles continue in the direction of their last move, the rotations are extrapolated by the
    /// same factor.
    fn extrapolate(&mut self, last_m: &[Vector3<f64>]) {
        let Some((before_m, before)) = &self.before else {
            return;
        };
        let (mut along, mut squared) = (0.0, 0.0);
        for ((next, last), before) in self.handles.moves_m.iter().zip(last_m).zip(before_m) {
            along += (next - last).dot(&(last - before));
            squared += (last - before).norm_squared();
        }
        // Length of the next move in units of the last one. Linear extrapolation beyond two of them is a poor guess.
        let steps = along / squared;
        if steps.is_finite() && steps.abs() <= 2.0 {
            let last = self.state.rotations.clone();
            let turns = last.turns_from(before);
            self.state.rotations.set_turned(&last, &turns, steps);
        }
    }
}
