//! Measures a model on fresh simulated scans.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use classifier::{Model, Provider, shipped_model};
use indicatif::ProgressBar;
use serde::Serialize;
use sim_scan::ScanParameters;
use training::evaluation::figures::Figures;
use training::evaluation::{self, Settings, Tests, real, shift};

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
    /// Measure so many times, with this seed, the next one, and so on
    #[arg(long, value_name = "COUNT", default_value = "1", conflicts_with_all = ["shift", "real", "json"])]
    seeds: NonZeroUsize,
    /// Also measure on the meshes of this dataset, made by generate_dataset; of one that the model was trained on, on those
    /// that were held out
    #[arg(long, value_name = "FOLDER")]
    dataset: Option<PathBuf>,
    /// Scans like the demo's: camera mount known exactly, wrist upright, object held in the middle of the image
    #[arg(long)]
    nominal: bool,
    /// Let one thing at a time leave the range that was trained on, step by step, on held objects
    #[arg(long, conflicts_with_all = ["dataset", "nominal", "real"])]
    shift: bool,
    /// Name the real scans and views in this folder instead, each once
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["dataset", "nominal", "figures"])]
    real: Option<PathBuf>,
    /// Also put the results into this file, and its tables into the page beside it (.md); of the other kind of test, what was
    /// there stays
    #[arg(long, value_name = "JSON")]
    figures: Option<PathBuf>,
    /// Also put the few most important rows into this Markdown file, between its two marks
    #[arg(long, value_name = "MD", requires = "figures")]
    summary: Option<PathBuf>,
    /// Measure nothing: make page and summary of the file of results as it is
    #[arg(long, requires = "figures", conflicts_with_all = ["shift", "dataset", "nominal"])]
    redraw: bool,
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
    if let Some(folder) = &arguments.real {
        let answers = real::measure(&mut model, folder)?;
        return show(arguments, &answers, || real::to_text(&answers));
    }
    // Read before all work, so that a damaged file is found first.
    let figures = arguments.figures.as_ref();
    let mut figures = figures
        .map(|path| Figures::read(path).map(|figures| (path, figures)))
        .transpose()?;
    if !arguments.redraw {
        measure(
            arguments,
            &mut model,
            figures.as_mut().map(|(_, figures)| figures),
        )?;
    }
    let Some((path, figures)) = figures else {
        return Ok(());
    };
    figures.write(path)?;
    match &arguments.summary {
        Some(summary) => figures.write_within(summary),
        None => Ok(()),
    }
}

fn measure(arguments: &Arguments, model: &mut Model, figures: Option<&mut Figures>) -> Result<()> {
    let bar = ProgressBar::new_spinner();
    if arguments.shift {
        let (specimens, seed) = (arguments.specimens, arguments.seed);
        let found = shift::measure(model, &shift::all(), specimens, seed, || bar.inc(1))?;
        bar.finish_and_clear();
        show(arguments, &found, || found.to_text())?;
        if let Some(figures) = figures {
            figures.shifts = Some(found);
        }
        return Ok(());
    }
    let mut all = Vec::new();
    for seed in (arguments.seed..).take(arguments.seeds.get()) {
        let found = evaluation::evaluate(model, &settings(arguments, seed), || bar.inc(1))?;
        bar.suspend(|| show(arguments, &found, || found.to_text()))?;
        all.push(found);
    }
    bar.finish_and_clear();
    if let Some(figures) = figures {
        figures.tests = Some(Tests::of(&all));
    }
    Ok(())
}

fn settings(arguments: &Arguments, seed: u64) -> Settings {
    Settings {
        specimens: arguments.specimens,
        dataset: arguments.dataset.clone(),
        scans: if arguments.nominal {
            ScanParameters::nominal()
        } else {
            ScanParameters::default()
        },
        seed,
    }
}

fn show(
    arguments: &Arguments,
    found: &impl Serialize,
    text: impl FnOnce() -> String,
) -> Result<()> {
    if arguments.json {
        program::print(format_args!("{:#}\n", serde_json::to_value(found)?))
    } else {
        program::print(text())
    }
}
