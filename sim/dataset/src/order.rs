//! What is asked for, and what its maker is told meanwhile.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use crate::object::Source;
use crate::settings::Settings;
use crate::shard::Shard;

/// What to make, and how.
#[derive(Debug, Clone)]
pub struct Order {
    /// What is dented; the names differ.
    pub sources: Vec<Source>,
    /// The dataset's folder.
    pub out: PathBuf,
    /// Meshes of each object; by the paper's sampling ratio when `None`.
    pub count: Option<NonZeroUsize>,
    /// Everything random comes from this.
    pub seed: u64,
    /// Threads.
    pub jobs: NonZeroUsize,
    /// The part to make; all when `None`.
    pub shard: Option<Shard>,
    /// How meshes are made.
    pub settings: Settings,
}

/// What a run is at, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Progress {
    /// Objects are being prepared.
    Preparing {
        /// How many.
        objects: usize,
    },
    /// One object is prepared.
    Prepared,
    /// Meshes are being made.
    Making {
        /// How many are wanted.
        meshes: usize,
        /// How many of these earlier runs have finished.
        kept: usize,
    },
    /// Some meshes are finished.
    Made {
        /// How many.
        meshes: usize,
    },
}
