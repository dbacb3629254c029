//! Names the object in clouds from files.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum};
use classifier::{Model, Provider, shipped_model};
use classify_files::{Scene, classify_views, measure_deformation, read_views};
use deformation::{Library, shipped_references};
use indicatif::ProgressBar;
use nalgebra::Point3;
use roi_crop::Axis;

/// Names the object in clouds: each FILE (PLY or PCD) is one view of the same scene.
#[derive(Debug, Parser)]
#[command(
    name = "classify_files",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Views of the scene, .ply or .pcd
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Model file [default: the shipped one]
    #[arg(long, value_name = "ONNX")]
    model: Option<PathBuf>,
    /// What runs the network: openvino or cpu
    #[arg(long, default_value = "openvino")]
    provider: Provider,
    /// OpenVINO's device
    #[arg(long, default_value = "CPU", value_parser = ["CPU", "GPU", "AUTO"])]
    device: String,
    /// The files' unit
    #[arg(long, default_value = "m")]
    units: Units,
    /// Up direction in the files' frame: ±x, ±y or ±z
    #[arg(
        long,
        default_value = "+z",
        value_name = "±AXIS",
        allow_hyphen_values = true
    )]
    up: Axis,
    /// Cut away what is not higher than this along the up direction, in metres [default: keep all]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    keep_above: Option<f64>,
    /// Where registration starts; files hold no poses, so that only `identity` works
    #[arg(long, default_value = "identity")]
    initial_guess: InitialGuess,
    /// Say where the object is dented, too
    #[arg(long)]
    deformation: bool,
    /// Undeformed objects, LABEL.ply, to compare with [default: the shipped ones]
    #[arg(long, value_name = "FOLDER", requires = "deformation")]
    references: Option<PathBuf>,
    /// Where the camera was in each file's frame, m; 0,0,0 for clouds as a camera gives them [default: unknown]
    #[arg(long, value_name = "X,Y,Z", requires = "deformation", allow_hyphen_values = true, value_parser = place)]
    viewpoint: Option<Point3<f64>>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Units {
    M,
    Mm,
}

#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum InitialGuess {
    Identity,
    Kinematic,
}

fn place(text: &str) -> Result<Point3<f64>, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map_while(|word| word.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok(Point3::new(x, y, z)),
        _ => Err("three numbers are needed, like 0,0,0".to_owned()),
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.initial_guess == InitialGuess::Kinematic {
        let message = "--initial-guess kinematic needs the hand's pose for each view, which PLY and \
                       PCD files do not hold; use identity";
        Arguments::command()
            .error(ErrorKind::InvalidValue, message)
            .exit();
    }
    program::exit_code("classify_files", run(&arguments))
}

fn run(arguments: &Arguments) -> Result<()> {
    let path = match &arguments.model {
        Some(path) => path.clone(),
        None => shipped_model()?,
    };
    let mut model = Model::load(&path, arguments.provider, &arguments.device)?;
    if let Some(reason) = model.fallback_reason() {
        program::note(format_args!(
            "classify_files: the CPU provider is used: {reason}"
        ));
    }
    let references = match (arguments.deformation, &arguments.references) {
        (false, _) => None,
        (true, Some(folder)) => Some(Library::open(folder)?),
        (true, None) => Some(Library::open(shipped_references()?)?),
    };
    let scene = Scene {
        metres_per_file_unit: match arguments.units {
            Units::M => 1.0,
            Units::Mm => 0.001,
        },
        up: arguments.up,
        keep_above_m: arguments.keep_above,
    };
    let bar = ProgressBar::new(arguments.files.len() as u64);
    let views = read_views(&arguments.files, scene.metres_per_file_unit, || bar.inc(1))?;
    bar.finish_and_clear();
    let classified =
        classify_views(&views, &scene, &mut model).context("cannot classify these views")?;
    for (view, file) in classified.views.iter().zip(&arguments.files) {
        if !view.accepted {
            program::note(format_args!(
                "classify_files: {} is left out: {}",
                file.display(),
                view.reason
            ));
        }
    }
    let deformed =
        references.map(|library| measure_deformation(&classified, &library, arguments.viewpoint));
    if arguments.json {
        let mut answer = classified.to_json(&model);
        if let Some(deformed) = &deformed {
            answer["deformation"] = deformed.to_json();
            answer["timing_ms"]["deformation"] = (1e3 * deformed.time.as_secs_f64()).into();
        }
        program::print(format_args!("{answer:#}\n"))?;
    } else {
        program::print(classified.to_text(&model))?;
        if let Some(deformed) = &deformed {
            program::print(format_args!("{}\n", deformed.summary))?;
        }
    }
    Ok(())
}
