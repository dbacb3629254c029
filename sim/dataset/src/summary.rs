//! Summary of a run, as text and as JSON.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use crate::folder::Folder;
use crate::manifest::Row;

/// The contents of the folder after a run, and the run's share of them.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// The dataset's folder.
    pub out: PathBuf,
    /// manifest.csv, with one row a mesh.
    pub manifest: PathBuf,
    /// run.yaml, with everything that determines the dataset.
    pub record: PathBuf,
    /// Plots of the losses by intensity, for each object and for all together.
    pub plots: Vec<PathBuf>,
    /// Number of meshes in the folder.
    pub meshes: usize,
    /// Number of meshes dented less than asked.
    pub clamped: usize,
    /// Number of meshes that are missing because the object could not be dented there.
    pub refused: usize,
    /// What to check before the meshes are used; empty if nothing looks wrong.
    pub warnings: Vec<String>,
    /// Number of rows of earlier runs.
    pub kept: usize,
    /// Number of rows of this run.
    pub made: usize,
    /// Duration of this run, s.
    pub seconds: f64,
    /// Rows of this run per second.
    pub meshes_per_second: f64,
    /// Peak memory of this process, MiB; `None` where the system does not tell.
    pub peak_memory_mib: Option<f64>,
}

impl Summary {
    /// Summarises the rows, of which `kept` are from earlier runs. `doubts` concern the objects' meshes.
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
