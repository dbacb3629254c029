//! The eight objects of the paper as parametric triangle meshes, and others that are none of them.
//!
//! [`ObjectClass::mesh`] is the very object that the paper's laboratory has, as traced from its scan; an [`Instance`] is one of
//! what the world has of it.
//!
//! All lengths are metres. Object frame: origin at the centre of the bottom, +z up. The eight are
//! closed surfaces of revolution (cups have an outer and an inner wall), oriented outward.
//!
//! ```
//! use sim_objects::{ObjectClass, Variation};
//!
//! let can = ObjectClass::MediumCan.mesh(&Variation::random(7));
//! assert!(can.is_closed_manifold());
//! ```

mod class;
mod family;
mod near;
mod outline;
mod profile;
mod solid;
mod stranger;
mod variation;

pub use class::{ObjectClass, UnknownObject};
pub use family::{Instance, Instances};
pub use near::{Difference, NearStranger};
pub use solid::random_solid;
pub use stranger::Stranger;
pub use variation::Variation;
