//! How a gripper dents an object: as-rigid-as-possible deformation of its mesh (paper Sec. IV).

pub mod arap;
mod one_ring;

pub use one_ring::MeshFault;
