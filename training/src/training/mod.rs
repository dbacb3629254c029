//! Fits a network to labelled clouds.

pub mod checkpoint;
pub mod epoch;
pub mod optimizer;
pub(crate) mod passes;
pub(crate) mod tally;
pub mod trainer;
