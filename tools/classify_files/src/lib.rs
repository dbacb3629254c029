//! Names the object in clouds from files, with the nodes' own code and without ROS.

mod classify;
mod deformed;

pub use classify::{Classified, Scene, classify_views, read_views};
pub use deformed::{Deformed, measure_deformation};
