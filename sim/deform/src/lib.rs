//! How a gripper dents an object: as-rigid-as-possible deformation of its mesh (paper Sec. IV).

pub mod arap;
pub mod denter;
mod flatten;
pub mod grasp;
pub mod intersect;
pub mod loss;
mod one_ring;
mod settings;
mod specimen;

pub use denter::{Dent, DentError, Denter};
pub use flatten::Flattening;
pub use one_ring::MeshFault;
pub use settings::Settings;
pub use specimen::{SQUEEZE_MAX_M, SqueezeError, pressed, specimen, squeeze};
