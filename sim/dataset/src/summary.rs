//! What a run did, for people and programs.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use crate::folder::Folder;
use crate::manifest::Row;

/// What is in the folder now, and what the run did for it.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// The folder.
    pub out: PathBuf,
    /// One row a mesh.
    pub manifest: PathBuf,
    /// What determines the dataset.
    pub record: PathBuf,
    /// Losses by intensity: of each object, and of all.
    pub plots: Vec<PathBuf>,
    /// Meshes in the folder.
    pub meshes: usize,
    /// Meshes dented less than asked.
    pub clamped: usize,
    /// Meshes that are not there, since the object could not be dented so.
    pub refused: usize,
    /// What to look at before the meshes are used; empty where all is well.
    pub warnings: Vec<String>,
    /// Rows of earlier runs.
    pub kept: usize,
    /// Rows of this run.
    pub made: usize,
    /// Time of this run.
    pub seconds: f64,
    /// Rows of this run a second.
    pub meshes_per_second: f64,
    /// Most memory of this process, MiB; `None` where the system does not say.
    pub peak_memory_mib: Option<f64>,
}

impl Summary {
    /// Counts what the rows say; `kept` of them are from earlier runs. `doubts` are about the objects' meshes.
    pub fn new(
        folder: &Folder,
        rows: &[Row],
        doubts: Vec<String>,
        plots: Vec<PathBuf>,
        kept: usize,
        time: Duration,
    ) -> Self {
        let made = rows.len() - kept;
        let seconds = time.as_secs_f64();
        let refused = rows.iter().filter(|row| !row.has_mesh()).count();
        let lowered = rows.iter().filter(|row| row.applied_mm < row.asked_mm);
        let clamped = lowered.count() - refused;
        let mut warnings = doubts;
        for (count, what) in [
            (clamped, "dented less than asked"),
            (refused, "not dented at all"),
        ] {
            if 2 * count > rows.len() {
                warnings.push(format!(
                    "most meshes ({count} of {}) were {what}",
                    rows.len()
                ));
            }
        }
        Self {
            out: folder.root().to_path_buf(),
            manifest: folder.manifest(),
            record: folder.record(),
            plots,
            meshes: rows.len() - refused,
            kept,
            made,
            clamped,
            refused,
            warnings,
            seconds,
            meshes_per_second: made as f64 / seconds,
            peak_memory_mib: peak_memory_mib(),
        }
    }

    /// A few lines for people.
    pub fn to_text(&self) -> String {
        let kept = match self.kept {
            0 => String::new(),
            kept => format!(", {kept} of earlier runs"),
        };
        let warnings = self.warnings.iter();
        let warnings: String = warnings
            .map(|warning| format!("warning: {warning}\n"))
            .collect();
        let memory = self.peak_memory_mib;
        let memory = memory.map_or(String::new(), |mib| format!("; {mib:.0} MiB at most"));
        format!(
            "{} meshes in {}: {} in {:.1} s ({:.1} a second){kept}{memory}\n\
             {} were dented less than asked, {} not at all\n{warnings}",
            self.meshes,
            self.out.display(),
            self.made,
            self.seconds,
            self.meshes_per_second,
            self.clamped,
            self.refused,
        )
    }
}

fn peak_memory_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kib / 1024.0)
}
