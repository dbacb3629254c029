//! Triangle meshes: the type, simple solids, adjacency (half-edges, one-rings, connected components), areas and normals,
//! points on the surface, and files of scans and meshes.
//!
//! All lengths are metres.
//!
//! ```
//! use mesh::Mesh;
//!
//! let can = Mesh::cylinder(0.033, 0.0, 0.12, 64);
//! assert!(can.is_closed_manifold());
//! ```

mod components;
pub mod file;
mod half_edges;
mod mesh;
mod revolve;
mod rows;
mod surface;
pub mod triangle;

pub use components::components;
pub use half_edges::{Edge, HalfEdge, HalfEdges, Spoke, sides};
pub use mesh::Mesh;
pub use revolve::revolve;
pub use rows::Rows;
pub use triangle::vertex_normals;
