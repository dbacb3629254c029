//! Handles as Lagrange multipliers: the factor of the free system is made once for a source mesh, and a small bordered
//! (Schur complement) system adds the constraints of each set of handles.

use nalgebra::{DMatrix, Vector3};

use super::block::Lane;
use super::cholesky::Cholesky;
use super::energy::{Rotations, Surface};
use super::minimise::Places;

/// The factored Laplacian of the vertices that are not held. A component without a held vertex would leave it singular:
/// one of its vertices is grounded (fixed at displacement 0), and the component may be shifted as a whole afterwards.
#[derive(Debug, Clone)]
pub(super) struct FreeSystem {
    pub factor: Cholesky,
    /// Whether a vertex is held or grounded.
    pub fixed: Vec<bool>,
    /// For each vertex the number of its component if that has no held vertex; empty if all components have one.
    pub floating: Vec<Option<u32>>,
    /// How many components have no held vertex.
    pub floating_count: usize,
}

/// A free system with constraints that move some vertices, the handles, to given positions.
#[derive(Debug, Clone)]
pub(super) struct Handles<'a> {
    system: &'a FreeSystem,
    pub vertices: Vec<usize>,
    /// L⁻¹·e for each handle's unit vector e, as (row, value); few entries differ from zero.
    columns: Vec<Vec<(u32, f64)>>,
    /// Inverse of the bordered system whose unknowns are the handles' forces (the Lagrange multipliers) and the shifts of
    /// the floating components.
    inverse: DMatrix<f64>,
    /// Wanted displacement of each handle from its rest position.
    pub moves_m: Vec<Vector3<f64>>,
    unknowns: Vec<Lane>,
}

impl<'a> Handles<'a> {
    /// `None` if the handles leave the system singular.
    pub fn new(system: &'a FreeSystem, vertices: Vec<usize>) -> Option<Self> {
        let columns = columns(system, &vertices);
        let (handles, size) = (vertices.len(), vertices.len() + system.floating_count);
        let mut bordered = DMatrix::zeros(size, size);
        for (row, vertex) in vertices.iter().enumerate() {
            for column in 0..=row {
                let product = sparse_dot(&columns[row], &columns[column]);
                (bordered[(row, column)], bordered[(column, row)]) = (product, product);
            }
            if let Some(component) = system.component(*vertex) {
                bordered[(row, handles + component)] = 1.0;
                bordered[(handles + component, row)] = 1.0;
            }
        }
        Some(Self {
            moves_m: vec![Vector3::zeros(); handles],
            unknowns: vec![[0.0; 4]; system.fixed.len()],
            inverse: bordered.try_inverse()?,
            system,
            vertices,
            columns,
        })
    }

    /// Forces at the handles that bring them to their targets, and shifts of the floating components.
    fn forces(&self) -> Vec<Lane> {
        let mut missing: Vec<Lane> = vec![[0.0; 4]; self.inverse.nrows()];
        for ((missing, column), wanted) in missing.iter_mut().zip(&self.columns).zip(&self.moves_m)
        {
            let mut sum = [wanted.x, wanted.y, wanted.z, 0.0];
            for &(row, factor) in column {
                let lane = &self.unknowns[row as usize];
                (0..4).for_each(|k| sum[k] -= factor * lane[k]);
            }
            *missing = sum;
        }
        let row = |row: usize| {
            let mut sum = [0.0; 4];
            for (column, lane) in missing.iter().enumerate() {
                (0..4).for_each(|k| sum[k] += self.inverse[(row, column)] * lane[k]);
            }
            sum
        };
        (0..missing.len()).map(row).collect()
    }
}

impl Places for Handles<'_> {
    fn settle(&mut self, surface: &Surface, rotations: &Rotations, moved_m: &mut [Vector3<f64>]) {
        surface.pulls(rotations, &mut self.unknowns);
        for (lane, fixed) in self.unknowns.iter_mut().zip(&self.system.fixed) {
            if *fixed {
                *lane = [0.0; 4];
            }
        }
        self.system.factor.solve_lower(&mut self.unknowns);
        let forces = self.forces();
        for (column, force) in self.columns.iter().zip(&forces) {
            for &(row, factor) in column {
                let lane = &mut self.unknowns[row as usize];
                (0..4).for_each(|k| lane[k] += factor * force[k]);
            }
        }
        self.system.factor.solve_upper(&mut self.unknowns);
        for (vertex, (moved, lane)) in moved_m.iter_mut().zip(&self.unknowns).enumerate() {
            let shift = self
                .system
                .component(vertex)
                .map_or([0.0; 4], |k| forces[self.vertices.len() + k]);
            *moved = Vector3::new(lane[0] + shift[0], lane[1] + shift[1], lane[2] + shift[2]);
        }
        // The solve brings the handles there to rounding; this makes it exact.
        for (&vertex, &wanted) in self.vertices.iter().zip(&self.moves_m) {
            moved_m[vertex] = wanted;
        }
    }
}

impl FreeSystem {
    fn component(&self, vertex: usize) -> Option<usize> {
        self.floating
            .get(vertex)
            .copied()
            .flatten()
            .map(|component| component as usize)
    }
}

fn columns(system: &FreeSystem, vertices: &[usize]) -> Vec<Vec<(u32, f64)>> {
    let mut columns = Vec::with_capacity(vertices.len());
    for handles in vertices.chunks(4) {
        let mut lanes: Vec<Lane> = vec![[0.0; 4]; system.fixed.len()];
        for (component, &handle) in handles.iter().enumerate() {
            // A grounded vertex moves only together with its component.
            lanes[handle][component] = if system.fixed[handle] { 0.0 } else { 1.0 };
        }
        system.factor.solve_lower(&mut lanes);
        for component in 0..handles.len() {
            let entries = lanes
                .iter()
                .enumerate()
                .filter(|(_, lane)| lane[component] != 0.0);
            columns.push(
                entries
                    .map(|(row, lane)| (row as u32, lane[component]))
                    .collect(),
            );
        }
    }
    columns
}

fn sparse_dot(a: &[(u32, f64)], b: &[(u32, f64)]) -> f64 {
    let (mut sum, mut rest) = (0.0, b);
    for &(row, factor) in a {
        while rest.first().is_some_and(|entry| entry.0 < row) {
            rest = &rest[1..];
        }
        if let Some(entry) = rest.first().filter(|entry| entry.0 == row) {
            sum += factor * entry.1;
        }
    }
    sum
}
