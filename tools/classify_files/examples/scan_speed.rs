//! How long the stages take on one scene's views, for tests/peers/registration: prints one JSON object.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use classifier::{Model, Provider};
use classify_files::{Classified, Scene, classify_views, read_views};
use roi_crop::Axis;
use serde_json::json;

/// Median times of classifying a scene again and again.
#[derive(Debug, Parser)]
struct Arguments {
    /// Views of the scene, .ply or .pcd, in m
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Model file
    #[arg(long)]
    model: PathBuf,
    /// Up direction in the files' frame: ±x, ±y or ±z
    #[arg(long, allow_hyphen_values = true)]
    up: Axis,
    /// Cut away what is not higher than this along the up direction, m
    #[arg(long, allow_negative_numbers = true)]
    keep_above: f64,
    /// How often
    #[arg(long, default_value_t = 40)]
    rounds: usize,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut model = Model::load(&arguments.model, Provider::OpenVino, "CPU")?;
    let views = read_views(&arguments.files, 1.0, || ())?;
    let scene = Scene {
        metres_per_file_unit: 1.0,
        up: arguments.up,
        keep_above_m: Some(arguments.keep_above),
    };
    let rounds = (0..arguments.rounds)
        .map(|_| classify_views(&views, &scene, &mut model))
        .collect::<Result<Vec<_>>>()?;
    let last = rounds.last().context("--rounds must be at least 1")?;
    let iterations: Vec<usize> = last.views.iter().map(|view| view.iterations).collect();
    let answer = json!({
        "label": last.answer.label,
        "iterations": iterations,
        "register_ms": median(rounds.iter().map(register_ms)),
        "total_ms": median(rounds.iter().map(total_ms)),
    });
    println!("{answer}");
    Ok(())
}

fn register_ms(classified: &Classified) -> f64 {
    1e3 * classified.register.as_secs_f64()
}

fn total_ms(classified: &Classified) -> f64 {
    let timing = &classified.answer.timing;
    let total = classified.register + classified.crop + timing.sample + timing.infer;
    1e3 * total.as_secs_f64()
}

fn median(times: impl Iterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
