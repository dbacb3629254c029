//! As-rigid-as-possible deformation with smooth rotations (paper Eq. 1 to 3; Sorkine and Alexa, "As-rigid-as-possible surface
//! modeling", SGP 2007).
//!
//! With w the mean cotangent of the angles opposite to an edge and S the source's surface area, a deformation has the
//! vertex positions v' and rotations R that minimise
//!
//! E = Σᵢ Σⱼ wᵢⱼ |(v'ᵢ−v'ⱼ) − Rᵢ(vᵢ−vⱼ)|² + α·S·Σᵢ Σⱼ |Rᵢ−Rⱼ|²,
//!
//! j running over i's neighbours, with some vertices held where they are and some handles moved to targets. Both terms
//! grow with the square of length, so that units do not matter.
//!
//! For given rotations the best positions solve a sparse linear system (ARAP's global step), whose matrix is the same for
//! all deformations of a source. This leaves a function of the rotations alone, which is close to quadratic. L-BFGS
//! minimises it, preconditioned by the Hessian of the smoothing term.
//!
//! [`Laplacian`] minimises the energy as the paper prints it instead.

mod block;
mod cholesky;
mod energy;
mod error;
mod grip;
mod handles;
mod laplacian;
mod minimise;
mod one_ring;
mod source;

pub use cholesky::FactorFault;
pub use error::ArapError;
pub use grip::{Deformed, Grip};
pub use laplacian::{Laplacian, LaplacianGrip};
pub use minimise::Stop;
pub use one_ring::MeshFault;
pub use source::{Arap, ArapSettings};

#[cfg(test)]
mod tests;
