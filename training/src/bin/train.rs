//! Makes simulated scans and trains a model on them, in one go.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use classifier::Centring;
use indicatif::{ProgressBar, ProgressStyle};
use training::network::NetworkKind;
use training::report;
use training::run::{self, Order, Stage};
use training::settings::Settings;
use training::trainer::EpochReport;

/// Trains a model on simulated scans of the eight objects, or on datasets of meshes.
///
/// The clouds go through the code of the nodes, and are kept for the next run with the same settings. The run's settings
/// and results are written to run.yaml in the run's folder. Started again after an interruption, the same command goes
/// on after the last whole epoch.
#[derive(Debug, Parser)]
#[command(
    name = "train",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Where the model goes; by default config/model.onnx, or model.onnx in --output for the paper's network
    #[arg(long, value_name = "ONNX")]
    model: Option<PathBuf>,
    /// Where datasets and runs go
    #[arg(long, default_value = "target/training", value_name = "FOLDER")]
    output: PathBuf,
    /// A folder made by generate_dataset, to train on instead of scans; may be given several times
    #[arg(long = "dataset", value_name = "FOLDER")]
    datasets: Vec<PathBuf>,
    /// Which network: the robot's, or the paper's with its settings
    #[arg(long, value_name = "NAME", default_value = "robot")]
    network: NetworkKind,
    /// Give the paper's network the points' normals, too
    #[arg(long, requires = "datasets")]
    normals: bool,
    /// Make the clouds again, though there are some with these settings, and forget an interrupted run; needed after a
    /// change of the nodes' code
    #[arg(long)]
    fresh: bool,
    /// Everything random comes from this
    #[arg(long)]
    seed: Option<u64>,
    /// Specimens of each class to train on
    #[arg(long)]
    specimens: Option<usize>,
    /// N, points of a cloud that the network sees
    #[arg(long = "points", visible_alias = "point-count", value_name = "N")]
    point_count: Option<usize>,
    /// How clouds are centred: box or centroid
    #[arg(long, value_parser = parse_centring)]
    centring: Option<Centring>,
    /// F, features of a point
    #[arg(long, value_name = "F")]
    features: Option<usize>,
    /// Most epochs
    #[arg(long)]
    epochs: Option<usize>,
    /// Epochs without a better validation loss before training stops
    #[arg(long)]
    patience: Option<usize>,
    /// Print the results as one JSON object
    #[arg(long)]
    json: bool,
}

fn parse_centring(text: &str) -> Result<Centring, String> {
    text.parse()
        .map_err(|()| format!("{text:?} is neither box nor centroid"))
}

impl Arguments {
    /// What is shipped is not replaced by a network of another kind.
    fn model(&self) -> PathBuf {
        let by_network = || match self.network {
            NetworkKind::Robot => PathBuf::from("config/model.onnx"),
            NetworkKind::Paper => self.output.join("model.onnx"),
        };
        self.model.clone().unwrap_or_else(by_network)
    }

    fn settings(&self) -> Settings {
        let mut settings = match self.network {
            NetworkKind::Robot => Settings::default(),
            NetworkKind::Paper => Settings::of_paper(),
        };
        let set = |to: &mut usize, from: Option<usize>| *to = from.unwrap_or(*to);
        settings.seed = self.seed.unwrap_or(settings.seed);
        set(&mut settings.specimens_per_class, self.specimens);
        set(&mut settings.point_count, self.point_count);
        if let Some(centring) = self.centring {
            settings.centring = centring.to_string();
        }
        if let Some(features) = self.features {
            settings.set_features(features);
        }
        settings.paper.normals = self.normals;
        set(&mut settings.training.epochs, self.epochs);
        set(&mut settings.training.patience, self.patience);
        settings
    }
}

fn main() -> ExitCode {
    report::exit_code("train", run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<()> {
    let bar = ProgressBar::new(0);
    let order = Order {
        settings: arguments.settings(),
        datasets: arguments.datasets.clone(),
        output: arguments.output.clone(),
        model: arguments.model(),
        fresh: arguments.fresh,
    };
    let results = run::run(&order, |stage| show(&bar, stage))?;
    bar.finish_and_clear();
    if arguments.json {
        println!("{:#}", serde_json::to_value(&results)?);
    } else {
        print!("{}", results.to_text());
    }
    Ok(())
}

fn show(bar: &ProgressBar, stage: Stage) {
    match stage {
        Stage::Scanning { specimens } => begin(bar, specimens, "scanning specimens"),
        Stage::Sampling { meshes } => begin(bar, meshes, "sampling meshes"),
        Stage::Scanned => advance(bar),
        Stage::Training { steps } => begin(bar, steps, "training"),
        Stage::Step {
            epoch,
            loss,
            accuracy,
        } => {
            bar.inc(1);
            bar.set_message(format!(
                "epoch {epoch}: loss {loss:.3}, accuracy {accuracy:.3}"
            ));
        }
        Stage::Resumed { epochs, steps } => {
            bar.set_position(steps as u64);
            bar.suspend(|| eprintln!("going on after epoch {epochs}"));
        }
        Stage::Epoch(report) => bar.suspend(|| eprintln!("{}", epoch_line(&report))),
    }
}

/// Without a terminal there is no bar; then a line for each tenth.
fn advance(bar: &ProgressBar) {
    bar.inc(1);
    let (done, length) = (bar.position(), bar.length().unwrap_or(0));
    if !std::io::stderr().is_terminal() && done % length.div_ceil(10).max(1) == 0 {
        eprintln!("{done} of {length}");
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
        eprintln!("{what}: {length} steps");
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
