//! Progress of a run, and its progress bar.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use crate::training::epoch::EpochReport;
use crate::training::trainer::Event;

/// Events of a run, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Stage {
    /// Scans are being made.
    Scanning {
        /// Number of specimens.
        specimens: usize,
    },
    /// Clouds are being made of meshes.
    Sampling {
        /// Number of meshes.
        meshes: usize,
    },
    /// One specimen or mesh is finished.
    Scanned,
    /// The network is being trained.
    Training {
        /// Largest possible number of steps.
        steps: usize,
    },
    /// An event of training.
    Trained(Event),
}

/// Updates the progress bar.
pub fn show(bar: &ProgressBar, stage: Stage) {
    match stage {
        Stage::Scanning { specimens } => begin(bar, specimens, "scanning specimens"),
        Stage::Sampling { meshes } => begin(bar, meshes, "sampling meshes"),
        Stage::Scanned => advance(bar),
        Stage::Training { steps } => begin(bar, steps, "training"),
        Stage::Trained(Event::Step {
            epoch,
            loss,
            accuracy,
        }) => {
            bar.inc(1);
            bar.set_message(format!(
                "epoch {epoch}: loss {loss:.3}, accuracy {accuracy:.3}"
            ));
        }
        Stage::Trained(Event::Resumed { epochs, steps }) => {
            bar.set_position(steps as u64);
            bar.suspend(|| program::note(format_args!("going on after epoch {epochs}")));
        }
        Stage::Trained(Event::Epoch(report)) => bar.suspend(|| program::note(epoch_line(&report))),
    }
}

/// Advances the bar; without a terminal, prints a line for each tenth instead.
fn advance(bar: &ProgressBar) {
    bar.inc(1);
    let (done, length) = (bar.position(), bar.length().unwrap_or(0));
    if !std::io::stderr().is_terminal() && done % length.div_ceil(10).max(1) == 0 {
        program::note(format_args!("{done} of {length}"));
    }
}

fn begin(bar: &ProgressBar, length: usize, what: &'static str) {
    let template = "{msg} [{bar:40}] {pos}/{len} {eta}";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.reset();
    bar.set_length(length as u64);
    bar.set_message(what);
    if !std::io::stderr().is_terminal() {
        program::note(format_args!("{what}: {length} steps"));
    }
}

fn epoch_line(report: &EpochReport) -> String {
    let best = if report.best { " (best)" } else { "" };
    format!(
        "epoch {:3}: loss {:.4}, accuracy {:.4}; validation loss {:.4}, accuracy {:.4}{best}",
        report.epoch,
        report.train_loss,
        report.train_accuracy,
        report.validation_loss,
        report.validation_accuracy
    )
}
