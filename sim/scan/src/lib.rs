//! Simulated scans without ROS: an object, held or on a box, before the camera, and the clouds that the nodes make of it.

mod dented;
mod parameters;
mod scan;
mod setup;

pub use dented::dented;
pub use parameters::ScanParameters;
pub use scan::{ScanError, ScannedObject, Shot, View, capture, capture_shots, full_view, scan};
pub use setup::Setup;
