//! Teaches the robot one more object.

mod text;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use adaptation::FitSettings;
use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use classifier::shipped_model;
use mesh::file::MILLIMETRE;
use serde_json::json;
use teach::object::Counts;
use teach::stored::Stored;
use teach::teach::{Order, Taught, check_new, teach};
use teach::{change, graph, prepare, views};

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
    #[arg(required_unless_present_any = ["list", "forget", "rename", "undo", "prepare"])]
    label: Option<String>,
    /// Points or a mesh of the object, +z up: PLY, PCD or OBJ [default: the robot records the object in its hand]
    #[arg(long, value_name = "FILE")]
    scan: Option<PathBuf>,
    /// Recorded views of the object, PLY or PCD: those of scan --save with the scan.yaml beside them, or of the object alone in
    /// one frame, +z up
    #[arg(long, value_name = "VIEW", num_args = 1.., conflicts_with = "scan")]
    files: Vec<PathBuf>,
    /// How often the object is grasped while the robot records it: 1 or 2; the second time upside down
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=2), conflicts_with_all = ["scan", "files"])]
    grasps: u32,
    /// Have the running classifier answer with the new model; always done where the robot records
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
    if arguments.prepare {
        let order = prepare::Order {
            counts: arguments.counts(),
            seed: arguments.seed,
        };
        let stop = stop_on_signal()?;
        let (path, bytes) = prepare::prepare(&arguments.model, order, &stop)?;
        return say(
            arguments,
            &format!("{}, {bytes} bytes, made for", path.display()),
        );
    }
    let from = match &arguments.from {
        Some(from) => from.clone(),
        None if arguments.model.exists() || arguments.undo => arguments.model.clone(),
        None => shipped_model()?,
    };
    let stored = Stored::open(&from)?;
    match changed(arguments, &stored)? {
        None => list(&stored, arguments.json),
        Some(Change::Done(done)) => {
            let loaded = arguments.load.then(|| use_in_graph(&arguments.model, None));
            say(arguments, &done)?;
            loaded.unwrap_or(Ok(()))
        }
        Some(Change::Taught(taught)) => {
            if let Some(doubt) = &taught.doubt {
                program::note(format_args!("teach: {doubt}"));
            }
            if arguments.json {
                program::print(format_args!("{:#}\n", serde_json::to_value(&taught)?))?;
            } else {
                program::print(text(&taught))?;
            }
            if arguments.load || (arguments.scan.is_none() && arguments.files.is_empty()) {
                use_in_graph(&taught.model, Some(&taught.reference))?;
            }
            Ok(())
        }
    }
}

enum Change {
    Done(String),
    Taught(Box<Taught>),
}

/// Changes the model as it is asked for; `None` where nothing is to be changed.
fn changed(arguments: &Arguments, stored: &Stored) -> Result<Option<Change>> {
    let out = &arguments.model;
    let done = |words: String| Ok(Some(Change::Done(words)));
    if arguments.list {
        return Ok(None);
    }
    if let Some(label) = &arguments.forget {
        change::forget(stored, label, out)?;
        return done(format!("forgot {label}"));
    }
    if let Some([label, to]) = arguments.rename.as_deref() {
        change::rename(stored, label, to, out)?;
        return done(format!("{label} is now called {to}"));
    }
    if arguments.undo {
        let step = change::undo(stored)?;
        return done(format!("took back: {}", words(&step.did)));
    }
    let label = arguments
        .label
        .clone()
        .context("no name of an object was given")?;
    // Before the arm moves for what cannot be taught.
    check_new(stored, &label)?;
    // Before the recording, which ends by the same signal once the arm rests.
    let stop = stop_on_signal()?;
    // Removed in the end.
    let folder = tempfile::tempdir().context("cannot make a folder for the views")?;
    let source = source(arguments, &label, folder.path())?;
    let order = Order {
        label,
        scan: source.scan,
        from: source.from,
        metres_per_unit: source.metres_per_unit,
        out: out.clone(),
        counts: arguments.counts(),
        fit: FitSettings::default(),
        seed: arguments.seed,
    };
    let taught = teach(stored, &order, &stop)?;
    Ok(Some(Change::Taught(Box::new(taught))))
}

/// Points or a mesh to teach.
struct Source {
    scan: PathBuf,
    from: String,
    metres_per_unit: f64,
}

/// What is to be taught, from where the arguments say; `folder` is for what is made of views.
fn source(arguments: &Arguments, label: &str, folder: &Path) -> Result<Source> {
    let metres_per_unit = |default: Units| match arguments.units.unwrap_or(default) {
        Units::M => 1.0,
        Units::Mm => MILLIMETRE,
    };
    let name_of = |file: &Path| file.file_name().unwrap_or_default().display().to_string();
    if let Some(first) = arguments.files.first() {
        let points = views::object_of(&arguments.files, metres_per_unit(Units::M))?;
        let scan = folder.join(format!("{label}.ply"));
        cloud::write_ply(&scan, &points)?;
        return Ok(Source {
            scan,
            from: format!(
                "{} and {} more views",
                name_of(first),
                arguments.files.len() - 1
            ),
            metres_per_unit: 1.0,
        });
    }
    let scan = match &arguments.scan {
        Some(scan) => scan.clone(),
        None => graph::record(label, arguments.grasps)?,
    };
    Ok(Source {
        from: name_of(&scan),
        metres_per_unit: metres_per_unit(Units::Mm),
        scan,
    })
}

/// Has the running graph use a model, and compare with the reference of what was taught.
fn use_in_graph(model: &Path, reference: Option<&Path>) -> Result<()> {
    // Before the model, so that the reference is there at the first answer with the new label.
    let (placed, misplaced) = match reference.map(graph::Placed::of).transpose() {
        Ok(placed) => (placed.flatten(), None),
        Err(error) => (None, Some(error)),
    };
    match graph::load(model) {
        Ok(id) => {
            program::note(format_args!(
                "the classifier answers with {id} from the next scan on"
            ));
            misplaced.map_or(Ok(()), Err)
        }
        Err(error) => {
            if let Some(placed) = placed {
                placed.take_back()?;
            }
            Err(error)
        }
    }
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
