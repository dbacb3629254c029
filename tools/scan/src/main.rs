//! Scans what the hand holds, from a terminal: asks the action `scan_object` and shows how it goes.

mod answer;
mod bar;
mod client;
mod folder;
mod recording;

use anyhow::{Context, Result};
use bar::Bar;
use clap::Parser;
use client::Client;
use folder::Folder;
use node::Node;
use recording::Recording;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// How long the clouds of a scan may take to come after its answer: they are said again each second.
const CLOUDS_PATIENCE: Duration = Duration::from_secs(5);

/// Looks at the object in the hand from several wrist angles and says which it is.
///
/// Ctrl-C ends the scan and waits until the arm is still.
#[derive(Debug, Parser)]
#[command(
    name = "scan",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// How many views [default: as view_capture is configured]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    views: Option<u32>,
    /// Print the answer as one JSON object
    #[arg(long)]
    json: bool,
    /// Make this folder, with each view, the registered cloud and the object as PCD and the answer as scan.yaml
    #[arg(long, value_name = "FOLDER")]
    save: Option<PathBuf>,
}

fn main() -> ExitCode {
    // The others are ROS's: names that are mapped, private parameters.
    let words = std::env::args().filter(|word| !word.contains(":="));
    let arguments = Arguments::parse_from(words);
    let mut result = None;
    let slot = &mut result;
    let code = node::run(&unique_name(), move |node| async move {
        *slot = Some(scan(&node, &arguments).await);
        Ok(())
    });
    match result {
        None => code,
        Some(Ok(())) => ExitCode::SUCCESS,
        Some(Err(error)) => {
            eprintln!("scan: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// A node's name is its own: the master ends the older of two that share one.
fn unique_name() -> String {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    format!("scan_{}_{}", std::process::id(), now.as_millis())
}

async fn scan(node: &Node, arguments: &Arguments) -> Result<()> {
    // What cannot be saved is said before the arm moves.
    let folder = arguments.save.as_deref().map(Folder::beside).transpose()?;
    let recording = match &folder {
        Some(_) => Some(Recording::listen(node).await?),
        None => None,
    };
    let mut client = Client::connect(node).await?;
    let bar = Bar::new();
    client.send(arguments.views.unwrap_or(0));
    let end = tokio::select! {
        end = client.follow(|report| bar.show(report)) => end,
        () = node.until_shutdown() => {
            bar.say("stopping the arm");
            client.cancel();
            client.end_of_cancelled().await
        }
    };
    bar.clear();
    let classification = end?;
    if let (Some(folder), Some(recording)) = (folder, &recording) {
        let recorded = recording
            .of(&classification.scan_id, CLOUDS_PATIENCE)
            .await?;
        let path = folder
            .save(&recorded, &classification)
            .context("cannot save the scan")?;
        eprintln!("saved in {}", path.display());
    }
    if arguments.json {
        println!("{:#}", answer::to_json(&classification));
    } else {
        println!("{}", answer::to_text(&classification));
    }
    Ok(())
}
