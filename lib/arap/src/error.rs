//! Errors of a deformation.

use nalgebra::Point3;

use super::cholesky::FactorFault;
use crate::one_ring::MeshFault;

/// Why a mesh cannot be deformed as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArapError {
    /// The mesh itself is unfit.
    #[error(transparent)]
    Mesh(#[from] MeshFault),
    /// A setting out of range.
    #[error("{name} is {value}; {wanted}")]
    Setting {
        /// The setting's name.
        name: &'static str,
        /// What it was set to.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// An index beyond the vertices.
    #[error(
        "vertex {vertex} is to be {role}, but there are {vertices} vertices; indices start at 0"
    )]
    NoSuchVertex {
        /// What the vertex is to be: held, or a handle.
        role: &'static str,
        /// Its index.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex named twice.
    #[error("vertex {vertex} is {role} twice; name each vertex once")]
    Repeated {
        /// What the vertex is to be: held, or a handle.
        role: &'static str,
        /// Its index.
        vertex: u32,
    },
    /// A handle that cannot move.
    #[error("vertex {vertex} is a handle, but it is held; take it out of one of the two")]
    HeldHandle {
        /// Index of the vertex.
        vertex: u32,
    },
    /// Nothing says where a part of the mesh is.
    #[error(
        "the {size} vertices connected with vertex {vertex} have neither a held vertex nor a handle; hold one of them, \
         or keep only the largest component of the mesh"
    )]
    Unconstrained {
        /// One of the vertices.
        vertex: u32,
        /// How many there are.
        size: usize,
    },
    /// Handles and targets do not pair up.
    #[error("{targets} targets for {handles} handles; each handle needs one")]
    TargetCount {
        /// How many targets were given.
        targets: usize,
        /// How many handles there are.
        handles: usize,
    },
    /// A target that no vertex can reach.
    #[error(
        "target {index} at {target} is not finite or more than {limit_m} m away from its handle"
    )]
    Target {
        /// Which target, in the handles' order.
        index: usize,
        /// Where it is.
        target: Point3<f64>,
        /// How far a handle may go.
        limit_m: f64,
    },
    /// The positions of a shape are not one a vertex, or not all finite.
    #[error(
        "a shape of {places} places, {finite} of them finite, for {vertices} vertices; each needs one"
    )]
    Shape {
        /// How many places were given.
        places: usize,
        /// How many of them are finite.
        finite: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// The system of the vertices or the handles is singular to rounding.
    #[error(
        "the system of the {system} cannot be factored ({cause}); the mesh is too distorted there"
    )]
    Singular {
        /// Which system.
        system: &'static str,
        /// What the solver says.
        cause: FactorFault,
    },
}
