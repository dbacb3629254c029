//! Datasets of dented objects: planning, making and storing them (paper Sec. IV-B 8, VI-A).
//!
//! The unit of work is one grasp of one object with all its intensities, each of which starts from the one before.
//! [`plan`] numbers units and meshes from the sources, the count and the seed alone, so that every thread, shard and
//! later run knows the same numbers. [`generate`] makes what is missing in a [`folder`]; [`merge`] joins shards.
//!
//! All lengths are metres, except in the files: there they are millimetres.

pub mod digest;
pub mod error;
pub mod folder;
pub mod generate;
pub mod journal;
pub mod manifest;
pub mod merge;
pub mod mesh_file;
pub mod object;
pub mod order;
pub mod plan;
pub mod plot;
pub mod record;
pub mod run;
pub mod settings;
pub mod shard;
pub mod summary;

pub use error::DatasetError;
