//! The eight objects of the paper as parametric triangle meshes, a simple dent, and files of scans and meshes.
//!
//! All lengths are metres. Object frame: origin at the centre of the bottom, +z up. Every mesh is a
//! closed surface of revolution (cups have an outer and an inner wall), oriented outward.
//!
//! ```
//! use sim_objects::{ObjectClass, Variation, dent};
//!
//! let can = ObjectClass::MediumCan.mesh(&Variation::random(7));
//! let dented = dent(&can, 0.008, 7)?;
//! assert_eq!(can.triangles, dented.triangles);
//! # Ok::<(), sim_objects::DentError>(())
//! ```

mod class;
mod dent;
pub mod file;
mod mesh;
mod profile;
mod variation;

pub use class::{ObjectClass, UnknownObject};
pub use dent::{DentError, SQUEEZE_MAX_M, dent};
pub use mesh::Mesh;
pub use profile::revolve;
pub use variation::Variation;
