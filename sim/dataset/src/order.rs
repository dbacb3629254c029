//! The order for a dataset, and reports of progress.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use crate::object::Source;
use crate::settings::Settings;
use crate::shard::Shard;

/// What to make, and how.
#[derive(Debug, Clone)]
pub struct Order {
    /// The objects to dent; their names must differ.
    pub sources: Vec<Source>,
    /// The dataset's folder.
    pub out: PathBuf,
    /// Number of meshes of each object; `None`: as many as the paper's sampling ratio gives.
    pub count: Option<NonZeroUsize>,
    /// Seed of all random choices.
    pub seed: u64,
    /// Number of threads.
    pub jobs: NonZeroUsize,
    /// The shard to make; `None` for the whole dataset.
    pub shard: Option<Shard>,
    /// How meshes are made.
    pub settings: Settings,
}

/// Events of a run, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Event {
    /// Objects are being prepared.
    Preparing {
        /// Number of objects.
        objects: usize,
    },
    /// One object is prepared.
    Prepared,
    /// Meshes are being made.
    Making {
        /// Number of meshes wanted.
        meshes: usize,
        /// Number of them that earlier runs have finished.
        kept: usize,
    },
    /// Some meshes are finished.
    Made {
        /// Number of meshes finished since the last such event.
        meshes: usize,
    },
}
