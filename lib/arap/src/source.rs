//! What is computed once for a source mesh: its weights and the factors of its linear systems.

use mesh::Mesh;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::cholesky::{self, Cholesky};
use super::energy::{Rotations, Surface};
use super::error::ArapError;
use super::handles::FreeSystem;
use super::minimise::{Limits, Places, State, minimise};
use crate::one_ring::OneRings;

/// How smooth and how exact a deformation is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArapSettings {
    /// α of Eq. 3: weight of the differences between neighbours' rotations; at least 0.
    pub smoothness: f64,
    /// A deformation ends when an iteration lowers its energy by less than this share of it; at least 0.
    pub energy_change_min: f64,
    /// A deformation ends after this many iterations at the latest.
    pub iterations_max: usize,
}

impl Default for ArapSettings {
    fn default() -> Self {
        Self {
            smoothness: 0.01,
            energy_change_min: 1e-5,
            iterations_max: 100,
        }
    }
}

/// A source mesh, ready to be deformed again and again.
#[derive(Debug, Clone)]
pub struct Arap {
    /// Its vertices are renumbered in the order of the factors (`order`).
    pub(super) surface: Surface,
    pub(super) system: FreeSystem,
    /// Factor of an approximate Hessian with respect to the rotations: smoothing term plus mean stiffness.
    pub(super) preconditioner: Cholesky,
    pub(super) limits: Limits,
    pub(super) held: Vec<bool>,
    /// The mesh's index of each renumbered vertex.
    pub(super) order: Vec<usize>,
    /// The inverse of `order`: the new number of each of the mesh's vertices.
    pub(super) places: Vec<usize>,
    /// Connected component of each renumbered vertex.
    pub(super) components: Vec<u32>,
    /// Farthest that a handle may be moved, in metres: many times the mesh's size, so that no square overflows.
    pub(super) reach_m: f64,
}

/// Share of the fixed-position Hessian's stiffness that the preconditioner keeps: the positions follow the rotations and so
/// lower the true one.
const GIVING_WAY: f64 = 0.5;
/// A handle may be moved by this many times the mesh's diagonal.
const REACH_MAX: f64 = 1e6;

impl Arap {
    /// Checks the mesh, computes cotangent weights and factors the system of the vertices that are not `held`.
    ///
    /// # Errors
    /// [`ArapError::Setting`], [`ArapError::Mesh`], [`ArapError::NoSuchVertex`] or [`ArapError::Repeated`] for unfit
    /// arguments; [`ArapError::Singular`] where a factor does not exist.
    pub fn new(mesh: &Mesh, held: &[u32], settings: ArapSettings) -> Result<Self, ArapError> {
        check(&settings)?;
        let rings = OneRings::new(mesh)?;
        let held = marked(held, rings.len(), "held")?;
        let order = cholesky::order(&rings).map_err(singular("edges"))?;
        let mut places = vec![0; order.len()];
        order
            .iter()
            .enumerate()
            .for_each(|(place, &vertex)| places[vertex] = place);
        let held: Vec<bool> = order.iter().map(|&vertex| held[vertex]).collect();
        let surface = Surface {
            rings: rings.renamed(&order),
            rest_m: order
                .iter()
                .map(|&vertex| mesh.vertices[vertex].coords.cast())
                .collect(),
            smoothing_m2: settings.smoothness * mesh.area_m2(),
        };
        let (component_of, _) = mesh::components(mesh.vertices.len(), &mesh.triangles);
        let components: Vec<u32> = order.iter().map(|&vertex| component_of[vertex]).collect();
        let (min, max) = mesh.bounds();
        Ok(Self {
            system: free_system(&surface.rings, &held, &components)?,
            preconditioner: preconditioner(&surface)?,
            limits: Limits {
                energy_change_min: settings.energy_change_min,
                iterations_max: settings.iterations_max,
            },
            reach_m: REACH_MAX * f64::from((max - min).norm()),
            surface,
            held,
            order,
            places,
            components,
        })
    }

    /// Energy of Eq. 3 in m², minimised over the rotations, for given vertex positions.
    ///
    /// # Errors
    /// [`ArapError::Shape`] unless there is one finite position for each vertex.
    pub fn energy_m2(&self, places_m: &[Point3<f64>]) -> Result<f64, ArapError> {
        let finite = places_m
            .iter()
            .filter(|place| place.iter().all(|part| part.is_finite()))
            .count();
        if finite != places_m.len() || places_m.len() != self.order.len() {
            return Err(ArapError::Shape {
                places: places_m.len(),
                finite,
                vertices: self.order.len(),
            });
        }
        let mut state = State::rest(self.order.len());
        for (name, &vertex) in self.order.iter().enumerate() {
            state.moved_m[name] = places_m[vertex].coords - self.surface.rest_m[name];
        }
        let limits = Limits {
            energy_change_min: 1e-9,
            iterations_max: 1000,
        };
        minimise(
            &self.surface,
            &self.preconditioner,
            &mut Given(state.moved_m.clone()),
            &mut state,
            limits,
        );
        Ok(state.energy_m2)
    }
}

/// Fixed displacements: no global step.
struct Given(Vec<Vector3<f64>>);

impl Places for Given {
    fn settle(&mut self, _: &Surface, _: &Rotations, moved_m: &mut [Vector3<f64>]) {
        moved_m.copy_from_slice(&self.0);
    }
}

pub(super) fn check(settings: &ArapSettings) -> Result<(), ArapError> {
    let shares = [
        ("smoothness", settings.smoothness),
        ("energy_change_min", settings.energy_change_min),
    ];
    for (name, value) in shares {
        if !(value.is_finite() && value >= 0.0) {
            let wanted = "it must be finite and not negative";
            return Err(ArapError::Setting {
                name,
                value,
                wanted,
            });
        }
    }
    Ok(())
}

/// For each of `count` vertices, whether `vertices` names it. Errors name vertices that are out of range or named twice.
pub(super) fn marked(
    vertices: &[u32],
    count: usize,
    role: &'static str,
) -> Result<Vec<bool>, ArapError> {
    let mut marked = vec![false; count];
    for &vertex in vertices {
        let mark = marked
            .get_mut(vertex as usize)
            .ok_or(ArapError::NoSuchVertex {
                role,
                vertex,
                vertices: count,
            })?;
        if std::mem::replace(mark, true) {
            return Err(ArapError::Repeated { role, vertex });
        }
    }
    Ok(marked)
}

pub(super) fn singular(system: &'static str) -> impl Fn(cholesky::FactorFault) -> ArapError {
    move |cause| ArapError::Singular { system, cause }
}

fn free_system(
    rings: &OneRings,
    held: &[bool],
    components: &[u32],
) -> Result<FreeSystem, ArapError> {
    let mut numbers: Vec<Option<u32>> = vec![None; rings.len()];
    held.iter()
        .zip(components)
        .filter(|(held, _)| **held)
        .for_each(|(_, &c)| numbers[c as usize] = Some(u32::MAX));
    let mut fixed = held.to_vec();
    let mut floating_count = 0;
    for (vertex, &component) in components.iter().enumerate() {
        numbers[component as usize].get_or_insert_with(|| {
            // Ground the first vertex of a component that has no held one.
            fixed[vertex] = true;
            floating_count += 1;
            floating_count - 1
        });
    }
    let number =
        |&component: &u32| numbers[component as usize].filter(|&number| number != u32::MAX);
    let floating = if floating_count == 0 {
        Vec::new()
    } else {
        components.iter().map(number).collect()
    };
    let diagonal = |vertex: usize| match fixed[vertex] {
        true => 1.0,
        false => rings.of(vertex).map(|(_, weight)| weight).sum(),
    };
    let factor = Cholesky::new(rings, |vertex| !fixed[vertex], diagonal, |weight| -weight)
        .map_err(singular("places"))?;
    Ok(FreeSystem {
        factor,
        floating,
        floating_count: floating_count as usize,
        fixed,
    })
}

fn preconditioner(surface: &Surface) -> Result<Cholesky, ArapError> {
    let stiffness: Vec<f64> = (0..surface.rings.len())
        .map(|vertex| surface.stiffness(vertex))
        .collect();
    let least = 1e-6 * stiffness.iter().sum::<f64>() / stiffness.len() as f64;
    // Second derivatives with respect to small rotations: 8·α·S for |Rᵢ−Rⱼ|², which Eq. 3 counts twice for each pair, and
    // on average over directions 4/3 of the stiffness for the first term.
    let tie = 8.0 * surface.smoothing_m2;
    let diagonal = |vertex: usize| {
        let own = GIVING_WAY * 4.0 / 3.0 * stiffness[vertex].max(least);
        tie * surface.rings.of(vertex).len() as f64 + own
    };
    Cholesky::new(&surface.rings, |_| true, diagonal, |_| -tie).map_err(singular("rotations"))
}
