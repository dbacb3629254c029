//! Scans what the hand holds, from a terminal: asks the action `scan_object` and shows how it goes.

use anyhow::{Context, Result};
use clap::Parser;
use msg::deformable_cobot::ScanObjectGoal;
use node::Node;
use scan::answer;
use scan::bar::Bar;
use scan::client::Client;
use scan::deformation::{self, Deformations};
use scan::folder::Folder;
use scan::program;
use scan::recording::Recording;
use std::path::PathBuf;
use std::process::ExitCode;

/// Looks at the object in the hand from several wrist angles and says which it is.
///
/// Ctrl-C ends the scan and waits until the arm is still.
#[derive(Debug, Parser)]
#[command(
    name = "scan",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// How many views, at each of which the wrist rests [default: as view_capture is configured]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    views: Option<u32>,
    /// Views during one sweep through so many radians, without a rest [default: as view_capture is configured]
    #[arg(long, value_name = "RAD", conflicts_with = "views")]
    range: Option<f64>,
    /// Print the answer as one JSON object
    #[arg(long)]
    json: bool,
    /// Make this folder, with each view, the registered cloud and the object as PCD, the answer as scan.yaml, and
    /// scan.html, which shows it in a browser
    #[arg(long, value_name = "FOLDER")]
    save: Option<PathBuf>,
}

fn main() -> ExitCode {
    program::run("scan", scan)
}

async fn scan(node: Node, arguments: Arguments) -> Result<()> {
    // What cannot be saved is said before the arm moves.
    let folder = arguments.save.as_deref().map(Folder::beside).transpose()?;
    let recording = match &folder {
        Some(_) => Some(Recording::listen(&node).await?),
        None => None,
    };
    let deformations = Deformations::listen(&node)?;
    let mut client = Client::connect(&node).await?;
    let bar = Bar::default();
    let goal = ScanObjectGoal {
        views: arguments.views.unwrap_or(0),
        range: arguments.range.unwrap_or(0.0),
    };
    let end = client.scan(goal, &bar).await;
    bar.clear();
    let classification = end?;
    let deformation = deformations.of(&classification.scan_id).await;
    if let (Some(folder), Some(recording)) = (folder, &recording) {
        let recorded = recording.of(&classification.scan_id).await?;
        let path = folder
            .save(&recorded, &classification, deformation.as_ref())
            .context("cannot save the scan")?;
        program::note(format_args!("saved in {}", path.display()));
    }
    if arguments.json {
        let mut answer = answer::to_json(&classification);
        answer["deformation"] = deformation.as_ref().map(deformation::to_json).into();
        program::print(format_args!("{answer:#}\n"))?;
    } else {
        program::print(format_args!("{}\n", answer::to_text(&classification)))?;
        if let Some(deformation) = deformation {
            program::print(format_args!("{}\n", deformation.summary))?;
        }
    }
    Ok(())
}
