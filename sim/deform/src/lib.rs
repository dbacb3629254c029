//! How a gripper dents an object: as-rigid-as-possible deformation of its mesh (paper Sec. IV).

pub mod grasp;
pub mod intersect;
pub mod loss;
