//! Trains the classifier on simulated scans (paper, Sec. V and VI) and measures it.

pub mod augment;
pub mod batch;
pub mod calibration;
pub mod dataset;
pub mod evaluation;
pub mod export;
pub mod files;
pub mod fused;
pub mod metrics;
pub mod network;
pub mod report;
pub mod run;
pub mod samples;
pub mod scan;
pub mod scan_parameters;
pub mod settings;
pub mod setup;
pub mod source;
pub mod trainer;
