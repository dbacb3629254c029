//! Trains the classifier on simulated scans (paper, Sec. V and VI) and measures it.
//!
//! [`data`] makes labelled clouds, [`network`] defines the networks and writes them to model files, [`training`] fits a
//! network to clouds, [`evaluation`] measures it, [`run`] does all of it in one go, and [`study`] does many runs.

pub mod code;
pub mod data;
pub mod evaluation;
pub mod kept;
pub mod network;
pub mod progress;
pub mod references;
pub mod run;
pub mod settings;
pub mod study;
pub mod training;
