//! Teaches the robot one more object.

mod text;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use adaptation::FitSettings;
use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use classifier::shipped_model;
use mesh::file::MILLIMETRE;
use record_object::{Grasps, Made};
use serde_json::json;
use teach::object::Counts;
use teach::progress::{Part, Progress};
use teach::source::Origin;
use teach::stored::Stored;
use teach::teach::{Order, Taught, check_new, teach};
use teach::{change, graph, prepare};

use text::{list, text, words};

/// Teaches a model one more object in about a minute: dents its mesh, looks at it in simulation, and fits the last layers of
/// the network to it and to what the model knew.
///
/// Without --scan the robot records the object in its hand first, and the running classifier gets the new model afterwards.
/// The new model goes to --model, with its features, the undented objects and the models of before beside it. Ctrl-C leaves
/// all as it was.
#[derive(Debug, Parser)]
#[command(
    name = "teach",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Name of the object; it becomes the label
    #[arg(required_unless_present_any = ["list", "forget", "rename", "undo", "prepare", "load"])]
    label: Option<String>,
    /// Points or a mesh of the object, +z up: PLY, PCD or OBJ [default: the robot records the object in its hand]
    #[arg(long, value_name = "FILE")]
    scan: Option<PathBuf>,
    /// Recorded views of the object, PLY or PCD: those of scan --save with the scan.yaml beside them, or of the object alone in
    /// one frame, +z up
    #[arg(long, value_name = "VIEW", num_args = 1.., conflicts_with = "scan")]
    files: Vec<PathBuf>,
    /// How often the object is grasped while the robot records it: 1 or 2; the second time upside down [default: a second time
    /// only where the first shows too little of it]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=2), conflicts_with_all = ["scan", "files"])]
    grasps: Option<u32>,
    /// Have the running classifier answer with the new model, which is always done where the robot records; without a LABEL:
    /// with --model as it is
    #[arg(long)]
    load: bool,
    /// The files' unit [default: mm of --scan, m of --files]
    #[arg(long)]
    units: Option<Units>,
    /// Where the new model goes
    #[arg(long, default_value = "taught.onnx", value_name = "ONNX")]
    model: PathBuf,
    /// The model to start from [default: --model if it is there, else the shipped one]
    #[arg(long, value_name = "ONNX")]
    from: Option<PathBuf>,
    /// Say what the model knows, since when and how well
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan", "files"])]
    list: bool,
    /// Remove an object
    #[arg(long, value_name = "LABEL", group = "instead", conflicts_with_all = ["label", "scan", "files"])]
    forget: Option<String>,
    /// Give an object another name
    #[arg(long, num_args = 2, value_names = ["OLD", "NEW"], group = "instead", conflicts_with_all = ["label", "scan", "files"])]
    rename: Option<Vec<String>>,
    /// Take the last step back
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan", "files", "from"])]
    undo: bool,
    /// Make the features of what --model knows, which teach needs and which lie beside the shipped one
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan", "files", "from"])]
    prepare: bool,
    /// Places where a gripper presses the object, each to six depths
    #[arg(long, value_name = "N", default_value_t = Counts::default().grasps, value_parser = at_least(4))]
    dents: usize,
    /// Simulated scans to learn from
    #[arg(long, value_name = "N", default_value_t = Counts::default().scans, value_parser = at_least(4))]
    scans: usize,
    /// Everything random comes from this
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print the results as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Units {
    M,
    Mm,
}

fn at_least(least: usize) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync {
    move |text| match text.parse() {
        Ok(count) if (least..=10_000).contains(&count) => Ok(count),
        _ => Err(format!("a whole number from {least} to 10000 is needed")),
    }
}

impl Arguments {
    /// Where the object comes from.
    fn origin(&self) -> Origin {
        let metres_per_unit = |default: Units| match self.units.unwrap_or(default) {
            Units::M => 1.0,
            Units::Mm => MILLIMETRE,
        };
        match (&self.scan, &self.files[..]) {
            (Some(scan), _) => Origin::File {
                scan: scan.clone(),
                metres_per_unit: metres_per_unit(Units::Mm),
            },
            (None, []) => Origin::Hand(match self.grasps {
                None => Grasps::AsNeeded,
                Some(1) => Grasps::One,
                Some(_) => Grasps::Two,
            }),
            (None, files) => Origin::Views {
                files: files.to_vec(),
                metres_per_unit: metres_per_unit(Units::M),
            },
        }
    }

    fn counts(&self) -> Counts {
        Counts {
            grasps: self.dents,
            scans: self.scans,
        }
    }
}

fn main() -> ExitCode {
    // The others are ROS's: names that are mapped, private parameters.
    let words = std::env::args().filter(|word| !word.contains(":="));
    program::exit_code("teach", run(&Arguments::parse_from(words)))
}

fn run(arguments: &Arguments) -> Result<()> {
    let out = &arguments.model;
    if arguments.prepare {
        let order = prepare::Order {
            counts: arguments.counts(),
            seed: arguments.seed,
        };
        let stop = stop_on_signal()?;
        let (path, bytes) = prepare::prepare(out, order, &stop)?;
        return say(
            arguments,
            &format!("{}, {bytes} bytes, made for", path.display()),
        );
    }
    let changes_nothing = arguments.label.is_none()
        && arguments.forget.is_none()
        && arguments.rename.is_none()
        && !arguments.undo
        && !arguments.list;
    if changes_nothing {
        program::note(graph::load_here(out)?);
        return say(arguments, "loaded");
    }
    let from = match &arguments.from {
        Some(from) => from.clone(),
        None if out.exists() || arguments.undo => out.clone(),
        None => shipped_model()?,
    };
    let stored = Stored::open(&from)?;
    if let Some(label) = &arguments.label {
        return teach_label(arguments, &stored, label);
    }
    let done = if let Some(label) = &arguments.forget {
        change::forget(&stored, label, out)?;
        format!("forgot {label}")
    } else if let Some([label, to]) = arguments.rename.as_deref() {
        change::rename(&stored, label, to, out)?;
        format!("{label} is now called {to}")
    } else if arguments.undo {
        format!("took back: {}", words(&change::undo(&stored)?.did))
    } else {
        return list(&stored, arguments.json);
    };
    let loaded = arguments.load.then(|| graph::load(out));
    say(arguments, &done)?;
    loaded.transpose()?.iter().for_each(program::note);
    Ok(())
}

/// Teaches an object, and has the running classifier answer with the new model where that is wanted.
fn teach_label(arguments: &Arguments, stored: &Stored, label: &str) -> Result<()> {
    // Before the arm moves for what cannot be taught.
    check_new(stored, label)?;
    // Before the recording, which hears the same signals and ends once the arm rests.
    let stop = stop_on_signal()?;
    let origin = arguments.origin();
    let by_robot = matches!(origin, Origin::Hand(_));
    let is_loaded = arguments.load || by_robot;
    let progress = Progress::new(&origin.parts(is_loaded));
    let done = taught(arguments, stored, label, &origin, &stop, &progress);
    let loaded = match &done {
        Ok(_) if is_loaded => {
            progress.begin(Part::Load, 1);
            Some(graph::load(&arguments.model))
        }
        _ => None,
    };
    progress.clear();
    let (taught, recorded) = done?;
    if let Some(doubt) = &taught.doubt {
        program::note(format_args!("teach: {doubt}"));
    }
    if arguments.json {
        let mut described = serde_json::to_value(&taught)?;
        described["recorded"] = json!(recorded.as_ref().map(Made::to_json));
        program::print(format_args!("{described:#}\n"))?;
    } else {
        program::print(text(&taught))?;
    }
    loaded.transpose()?.iter().for_each(program::note);
    Ok(())
}

/// Gets the object and teaches it.
fn taught(
    arguments: &Arguments,
    stored: &Stored,
    label: &str,
    origin: &Origin,
    stop: &AtomicBool,
    progress: &Progress,
) -> Result<(Taught, Option<Made>)> {
    // Removed in the end.
    let folder = tempfile::tempdir().context("cannot make a folder for the views")?;
    let source = origin.get(label, folder.path(), stop, progress)?;
    let order = Order {
        label: label.to_owned(),
        scan: source.scan,
        from: source.from,
        metres_per_unit: source.metres_per_unit,
        out: arguments.model.clone(),
        counts: arguments.counts(),
        fit: FitSettings::default(),
        seed: arguments.seed,
    };
    let taught = teach(stored, &order, stop, progress);
    let taught = taught.with_context(|| match &source.recorded {
        Some(made) => format!(
            "the recording is kept, to go on with: teach {label} --scan {} --load",
            made.file.display()
        ),
        None => format!("{label} was not taught"),
    })?;
    Ok((taught, source.recorded))
}

/// Becomes true at the first SIGINT or SIGTERM.
fn stop_on_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&stop);
    ctrlc::set_handler(move || set.store(true, Ordering::Relaxed))
        .context("cannot listen for signals")?;
    Ok(stop)
}

fn say(arguments: &Arguments, done: &str) -> Result<()> {
    let model = &arguments.model;
    if arguments.json {
        let described = json!({ "model": model, "done": done });
        return program::print(format_args!("{described:#}\n"));
    }
    program::print(format_args!("{done}: {}\n", model.display()))
}
