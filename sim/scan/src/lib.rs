//! Simulated scans without ROS: an object, held or on a box, before the camera, and the clouds that the nodes make of it.

mod dented;
mod flank;
mod parameters;
mod scan;
mod setup;
mod view;

pub use dented::{dented, dented_instance};
pub use flank::{lose_flank, object_in};
pub use parameters::ScanParameters;
pub use scan::{
    ScanError, ScannedObject, Shot, after_each_view, capture, capture_shots, full_view, scan,
};
pub use setup::{DISPARITY_SIGMA_PX, EDGE_MIXING, Setup};
pub use view::View;
