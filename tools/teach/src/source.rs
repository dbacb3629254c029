//! What is taught: a file, recorded views, or the object in the hand.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result};
use record_object::{Grasps, Made};

use crate::graph;
use crate::look::Watch;
use crate::progress::{Part, Progress};
use crate::views;

/// Where the object comes from.
#[derive(Debug, Clone)]
pub enum Origin {
    /// Points or a mesh in a file.
    File {
        /// The file.
        scan: PathBuf,
        /// Length of its unit, m.
        metres_per_unit: f64,
    },
    /// Recorded views.
    Views {
        /// Their files.
        files: Vec<PathBuf>,
        /// Length of their unit, m.
        metres_per_unit: f64,
    },
    /// The hand.
    Hand(Grasps),
}

/// Points or a mesh to teach.
#[derive(Debug)]
pub struct Source {
    /// The file.
    pub scan: PathBuf,
    /// What it was made of, for the history.
    pub from: String,
    /// Length of the file's unit, m.
    pub metres_per_unit: f64,
    /// What the robot recorded.
    pub recorded: Option<Made>,
}

impl Origin {
    /// What is shown while an object is taught from here; `is_loaded`: to the running classifier in the end.
    pub fn parts(&self, is_loaded: bool) -> Vec<Part> {
        let first = match self {
            Self::File { .. } => None,
            Self::Views { .. } => Some(Part::Register),
            Self::Hand(_) => Some(Part::Record),
        };
        let each = [
            Part::Mesh,
            Part::Dent,
            Part::Look,
            Part::Adapt,
            Part::Measure,
        ];
        let last = is_loaded.then_some(Part::Load);
        first.into_iter().chain(each).chain(last).collect()
    }

    /// Gets it; `folder` is for what is made of views.
    ///
    /// # Errors
    /// The views show no whole object, or the recording failed.
    pub fn get(
        &self,
        label: &str,
        folder: &Path,
        stop: &AtomicBool,
        progress: &Progress,
    ) -> Result<Source> {
        match self {
            Self::File {
                scan,
                metres_per_unit,
            } => Ok(Source {
                scan: scan.clone(),
                from: name_of(scan),
                metres_per_unit: *metres_per_unit,
                recorded: None,
            }),
            Self::Views {
                files,
                metres_per_unit,
            } => {
                progress.begin(Part::Register, files.len());
                let watch = Watch {
                    finished: &|| progress.step(),
                    stop,
                };
                let points = views::object_of(files, *metres_per_unit, &watch)?;
                let scan = folder.join(format!("{label}.ply"));
                cloud::write_ply(&scan, &points)
                    .with_context(|| format!("cannot write {}", scan.display()))?;
                let first = files.first().map(|file| name_of(file)).unwrap_or_default();
                Ok(Source {
                    scan,
                    from: format!("{first} and {} more views", files.len().saturating_sub(1)),
                    metres_per_unit: 1.0,
                    recorded: None,
                })
            }
            Self::Hand(grasps) => {
                let made = graph::record(label, *grasps, progress)?;
                Ok(Source {
                    scan: made.file.clone(),
                    from: name_of(&made.file),
                    metres_per_unit: mesh::file::MILLIMETRE,
                    recorded: Some(made),
                })
            }
        }
    }
}

fn name_of(file: &Path) -> String {
    file.file_name().unwrap_or_default().display().to_string()
}
