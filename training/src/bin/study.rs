//! Compares design choices of the paper's network.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use indicatif::ProgressBar;
use training::network::Head;
use training::network::backend::Backend;
use training::progress;
use training::settings::Settings;
use training::study::{StudyOrder, study};

/// Trains the paper's network with each number of features on each number of points, and reports on all.
///
/// report.html in the output folder has everything and needs no other file; beside it are the plots as PNG, the numbers
/// as CSV, and in cells/ each model. Started again, it trains only what is not finished.
#[derive(Debug, Parser)]
#[command(
    name = "study",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// A folder made by generate_dataset; may be given several times
    #[arg(long = "dataset", value_name = "FOLDER", required = true)]
    datasets: Vec<PathBuf>,
    /// Where everything goes
    #[arg(long, default_value = "target/training/study", value_name = "FOLDER")]
    output: PathBuf,
    /// F, numbers of features
    #[arg(long, value_delimiter = ',', default_values_t = [32, 48, 64, 80])]
    features: Vec<usize>,
    /// N, numbers of points
    #[arg(long, value_delimiter = ',', default_values_t = [25, 38, 50, 62, 100, 256, 512])]
    points: Vec<usize>,
    /// What the dense layer sees: the largest of each feature, or the features of all points; give each an output of its own
    #[arg(long, value_enum, default_value_t = Head::Pool)]
    head: Head,
    /// Most epochs
    #[arg(long)]
    epochs: Option<usize>,
    /// Everything random comes from this
    #[arg(long)]
    seed: Option<u64>,
    /// What runs the network: cpu, or cuda where it was built with that feature
    #[arg(long, default_value = "cpu")]
    device: Backend,
    /// Print the results as one JSON object
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    program::exit_code("study", run(Arguments::parse()))
}

fn run(arguments: Arguments) -> Result<()> {
    let mut settings = Settings::of_paper();
    settings.training.epochs = arguments.epochs.unwrap_or(settings.training.epochs);
    settings.paper.head = arguments.head;
    settings.seed = arguments.seed.unwrap_or(settings.seed);
    let order = StudyOrder {
        settings,
        datasets: arguments.datasets,
        features: arguments.features,
        points: arguments.points,
        output: arguments.output,
        backend: arguments.device,
    };
    let bar = ProgressBar::new(0);
    let begin = |features, points, trained| {
        let what = if trained {
            "training"
        } else {
            "finished before"
        };
        bar.suspend(|| program::note(format_args!("F = {features}, N = {points}: {what}")));
    };
    let cells = study(&order, begin, |stage| progress::show(&bar, stage))?;
    bar.finish_and_clear();
    if arguments.json {
        return program::print(format_args!(
            "{:#}\n",
            serde_json::json!({ "cells": cells })
        ));
    }
    for cell in &cells {
        let (features, points) = (cell.features, cell.points);
        let percent = 100.0 * cell.accuracy();
        program::print(format_args!(
            "F = {features:3}, N = {points:4}: {percent:6.2} %\n"
        ))?;
    }
    program::print(format_args!(
        "{}\n",
        order.output.join("report.html").display()
    ))
}
