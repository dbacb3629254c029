//! Errors of making and merging datasets, with their remedies.

use std::io;
use std::path::{Path, PathBuf};

use arap::ArapError;
use mesh::file::FileError;
use sim_deform::DentError;
use sim_deform::grasp::GraspError;
use sim_reconstruct::ReconstructError;

use crate::shard::Shard;

/// Why a dataset was not made, or not merged.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// Each object has a folder of its own name.
    #[error("two sources are called '{name}': rename one of the files")]
    SameName {
        /// The common name.
        name: String,
    },
    /// The file's stem cannot be a folder's name beside the dataset's own files.
    #[error(
        "'{name}' cannot name an object: rename the file to letters, digits, '-', '_' and inner dots, and not to 'references'"
    )]
    BadName {
        /// The file's stem.
        name: String,
    },
    /// A settings file that cannot be read or has a value out of range.
    #[error("settings {file}: {reason}")]
    Settings {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The object has too few grasps.
    #[error(
        "{object} can be grasped in {grasps} ways, which gives {meshes_max} meshes, and {count} were asked for: \
         ask for --count {meshes_max} or fewer"
    )]
    CountTooLarge {
        /// The object.
        object: String,
        /// Grasps that the gripper accepts.
        grasps: usize,
        /// Meshes that these give.
        meshes_max: usize,
        /// Meshes asked for.
        count: usize,
    },
    /// A scan that cannot be read, or a mesh that cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A scan of which no mesh can be made.
    #[error("{object}: {source}")]
    Reconstruct {
        /// The object.
        object: String,
        /// What is wrong with the scan.
        source: ReconstructError,
    },
    /// A size that no graspable object has.
    #[error("{object} is {size_m:.4} m long, and 0.01 to 1 m is expected: see --units")]
    Size {
        /// The object.
        object: String,
        /// Its longest extent, m.
        size_m: f32,
    },
    /// A mesh that cannot be dented.
    #[error("{object}: {source}")]
    Dent {
        /// The object.
        object: String,
        /// Why the mesh cannot be dented.
        source: DentError,
    },
    /// An operation on a file or folder failed.
    #[error("cannot {doing} {path}: {source}")]
    Io {
        /// The operation, as a verb.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A manifest, journal or record that is not as this program writes it.
    #[error("{path} is damaged ({reason}): use another --out")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A plot could not be drawn.
    #[error("cannot draw {path}: {reason}")]
    Plot {
        /// The file.
        path: PathBuf,
        /// What the plotting library says.
        reason: String,
    },
    /// Another run has locked the folder.
    #[error("another run is at work in {folder}: wait for its end, or use another --out")]
    InUse {
        /// The folder.
        folder: PathBuf,
    },
    /// A folder that holds other files and is no dataset.
    #[error("{folder} holds {found} and no run.yaml, so it is no dataset: use another --out")]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// The first thing found there.
        found: String,
    },
    /// A dataset made with other sources, settings or seed.
    #[error(
        "{folder} holds a dataset made in another way: {}; use another --out, or the same settings",
        differences.join("; ")
    )]
    Differs {
        /// The folder.
        folder: PathBuf,
        /// Each as "key: value there, value here".
        differences: Vec<String>,
    },
    /// A failure after the work began.
    #[error(
        "{}\n{done} of {total} meshes are finished and kept: the same command goes on from there",
        program::describe(cause.as_ref())
    )]
    Halted {
        /// Meshes finished, with those of earlier runs.
        done: usize,
        /// Meshes wanted.
        total: usize,
        /// The failure.
        cause: Box<DatasetError>,
    },
    /// No mesh could be made: the gripper cannot dent the object at any of the tried grasps.
    #[error(
        "none of {asked} meshes was made: {reason}; see the column note of {manifest}, and is the object's size right (--units)?"
    )]
    Nothing {
        /// Meshes asked for.
        asked: usize,
        /// Why the first of them failed.
        reason: String,
        /// The manifest, which has the reasons of all.
        manifest: PathBuf,
    },
    /// Asked to stop by a signal.
    #[error("stopped by a signal")]
    Stopped,
    /// Shards that cannot be merged.
    #[error(transparent)]
    Merge(#[from] MergeError),
}

/// Why shards cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder that holds a whole dataset.
    #[error("{part} is no part: it was made without --shard")]
    NoPart {
        /// The folder.
        part: PathBuf,
    },
    /// A shard whose run has not finished.
    #[error("{part} (shard {shard}) is not finished: run its command again")]
    Unfinished {
        /// The folder.
        part: PathBuf,
        /// Which part it is.
        shard: Shard,
    },
    /// Parts of two datasets.
    #[error("{first} and {second} are parts of different datasets: {}", differences.join("; "))]
    Differ {
        /// A folder.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Each as "key: value in the first, value in the second".
        differences: Vec<String>,
    },
    /// Two folders hold the same shard.
    #[error("{first} and {second} are both shard {shard}: leave one out")]
    Overlap {
        /// A folder.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Which part they are.
        shard: Shard,
    },
    /// Parts that were not given.
    #[error("missing: shard {}", shards.join(", "))]
    Gap {
        /// The missing shards, like "2/4".
        shards: Vec<String>,
    },
    /// A shard with a missing or changed file.
    #[error("{part} has no {missing} as it was made: run its command again")]
    Incomplete {
        /// The folder.
        part: PathBuf,
        /// What is missing.
        missing: String,
    },
    /// Another file has the name of a mesh.
    #[error(
        "{file} is there already and is none of the parts' meshes: move it away, or use another --out"
    )]
    InTheWay {
        /// The file.
        file: PathBuf,
    },
    /// The destination is in use.
    #[error("{out} holds a dataset already: use another --out")]
    Occupied {
        /// The folder.
        out: PathBuf,
    },
}

impl DatasetError {
    /// Whether this is a usage error (exit code 2): other arguments are the remedy.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Reconstruct { source, .. } => matches!(source, ReconstructError::Setting { .. }),
            Self::Dent { source, .. } => matches!(
                source,
                DentError::Grasp(GraspError::Setting { .. })
                    | DentError::Arap(ArapError::Setting { .. })
                    | DentError::Loss(_)
            ),
            Self::SameName { .. }
            | Self::BadName { .. }
            | Self::Settings { .. }
            | Self::CountTooLarge { .. } => true,
            _ => false,
        }
    }

    /// For `map_err`: adds the operation and the path to the system's error.
    pub(crate) fn io(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io {
            doing,
            path: path.to_path_buf(),
            source,
        }
    }

    pub(crate) fn damaged(path: &Path, reason: &dyn std::fmt::Display) -> Self {
        Self::Damaged {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        }
    }
}
