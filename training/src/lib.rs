//! Trains the classifier on simulated scans (paper, Sec. V and VI) and measures it.

pub mod augment;
pub mod batch;
pub mod checkpoint;
pub mod dataset;
pub mod evaluation;
pub mod export;
pub mod files;
pub mod fused;
pub mod mesh_clouds;
pub mod mesh_dataset;
pub mod metrics;
pub mod network;
pub mod optimizer;
pub mod product;
pub mod progress;
pub mod report;
pub mod run;
pub mod samples;
pub mod scan;
pub mod scan_parameters;
pub mod settings;
pub mod setup;
pub mod shared_max;
pub mod source;
pub mod study;
mod tally;
pub mod trainer;
