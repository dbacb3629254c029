//! How an object is deformed: its cloud against the undeformed shape.
//!
//! [`measure`] lays a [`Reference`] into an object's cloud, robustly, so that dents and fingers do not pull it; takes each
//! point's distance from it along its normals, in units of what the camera is uncertain by at that distance and angle;
//! and gathers what lies significantly inside to [`Dent`]s. [`Synthesis`] adds what they say of places that no camera saw.

mod answer;
mod bottom;
mod dent;
mod dents;
mod field;
mod fit;
mod layer;
mod library;
mod observation;
mod parameters;
mod placement;
mod reference;
mod shell;
mod sites;
mod starts;
mod synthesis;
mod words;

pub use answer::{Doubt, Measured, measure};
pub use dent::Dent;
pub use library::{Library, LibraryError, shipped_references};
pub use observation::Observation;
pub use parameters::Parameters;
pub use placement::Placement;
pub use reference::{Reference, ReferenceError};
pub use synthesis::{Synthesis, Unsaid};
