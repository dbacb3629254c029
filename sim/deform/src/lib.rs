//! How a gripper dents an object: as-rigid-as-possible deformation of its mesh (paper Sec. IV).

mod deformer;
pub mod denter;
mod flatten;
pub mod grasp;
pub mod intersect;
pub mod loss;
mod settings;
mod specimen;

pub use deformer::Energy;
pub use denter::{Dent, DentError, Denter};
pub use flatten::Flattening;
pub use settings::Settings;
pub use specimen::{
    SQUEEZE_MAX_M, SqueezeError, dented_instance, pressed_instance, specimen, squeeze,
};
