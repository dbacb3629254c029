//! Triangle meshes: the type, simple solids, points on the surface, and files of scans and meshes.
//!
//! All lengths are metres.
//!
//! ```
//! use mesh::Mesh;
//!
//! let can = Mesh::cylinder(0.033, 0.0, 0.12, 64);
//! assert!(can.is_closed_manifold());
//! ```

pub mod file;
mod mesh;
mod revolve;
mod surface;

pub use mesh::Mesh;
pub use revolve::revolve;
