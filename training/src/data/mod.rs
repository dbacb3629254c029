//! Labelled clouds: made of simulated scans and of meshes, stored in files, augmented at random during training.

pub mod augment;
pub mod clouds;
pub mod mesh_clouds;
pub mod mesh_dataset;
mod scans;
pub mod simulate;
pub mod source;
pub mod specimens;
pub(crate) mod split;
pub mod trained_on;

pub use clouds::{LabelledClouds, Split};
