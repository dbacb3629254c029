//! How a gripper dents an object: as-rigid-as-possible deformation of its mesh (paper Sec. IV).
