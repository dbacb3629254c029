//! Measures a model on fresh simulated scans.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use classifier::{Model, Provider, shipped_model};
use indicatif::ProgressBar;
use sim_scan::ScanParameters;
use training::evaluation::{self, Settings};

/// Measures a model on simulated scans that it was not trained on.
#[derive(Debug, Parser)]
#[command(
    name = "evaluate",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Model file [default: the shipped one]
    #[arg(long, value_name = "ONNX")]
    model: Option<PathBuf>,
    /// What runs the network: openvino or cpu
    #[arg(long, default_value = "cpu")]
    provider: Provider,
    /// OpenVINO's device
    #[arg(long, default_value = "CPU", value_parser = ["CPU", "GPU", "AUTO"])]
    device: String,
    /// Specimens of each class
    #[arg(long, default_value = "30")]
    specimens: NonZeroUsize,
    /// Everything random comes from this; other than a training run's
    #[arg(long, default_value_t = 9001)]
    seed: u64,
    /// Also measure on the meshes of this dataset, made by generate_dataset; of one that the model was trained on, on those
    /// that were held out
    #[arg(long, value_name = "FOLDER")]
    dataset: Option<PathBuf>,
    /// Scans like the demo's: camera mount known exactly, wrist upright, object held in the middle of the image
    #[arg(long)]
    nominal: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    program::exit_code("evaluate", run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<()> {
    let path = match &arguments.model {
        Some(path) => path.clone(),
        None => shipped_model()?,
    };
    let mut model = Model::load(&path, arguments.provider, &arguments.device)?;
    if let Some(reason) = model.fallback_reason() {
        program::note(format_args!("evaluate: the CPU provider is used: {reason}"));
    }
    let parameters = if arguments.nominal {
        ScanParameters::nominal()
    } else {
        ScanParameters::default()
    };
    let settings = Settings {
        specimens: arguments.specimens,
        dataset: arguments.dataset.clone(),
        scans: parameters,
        seed: arguments.seed,
    };
    let bar = ProgressBar::new_spinner();
    let found = evaluation::evaluate(&mut model, &settings, || bar.inc(1))?;
    bar.finish_and_clear();
    if arguments.json {
        program::print(format_args!("{:#}\n", serde_json::to_value(&found)?))?;
    } else {
        program::print(found.to_text())?;
    }
    Ok(())
}
