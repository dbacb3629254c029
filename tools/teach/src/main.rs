//! Teaches the robot one more object.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use adaptation::FitSettings;
use anyhow::{Context, Result};
use clap::{Parser, ValueEnum};
use classifier::shipped_model;
use serde_json::json;
use teach::history::{Did, origin_of};
use teach::object::Counts;
use teach::stored::Stored;
use teach::teach::{Order, Taught, check_new, teach};
use teach::{change, graph, look, prepare};

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
    /// How often the object is grasped while the robot records it: 1 or 2; the second time upside down
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=2), conflicts_with = "scan")]
    grasps: u32,
    /// Have the running classifier answer with the new model; always done where the robot records
    #[arg(long)]
    load: bool,
    /// The scan's unit
    #[arg(long, default_value = "mm")]
    units: Units,
    /// Where the new model goes
    #[arg(long, default_value = "taught.onnx", value_name = "ONNX")]
    model: PathBuf,
    /// The model to start from [default: --model if it is there, else the shipped one]
    #[arg(long, value_name = "ONNX")]
    from: Option<PathBuf>,
    /// Say what the model knows, since when and how well
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan"])]
    list: bool,
    /// Remove an object
    #[arg(long, value_name = "LABEL", group = "instead", conflicts_with_all = ["label", "scan"])]
    forget: Option<String>,
    /// Give an object another name
    #[arg(long, num_args = 2, value_names = ["OLD", "NEW"], group = "instead", conflicts_with_all = ["label", "scan"])]
    rename: Option<Vec<String>>,
    /// Take the last step back
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan", "from"])]
    undo: bool,
    /// Make the features of what --model knows, which teach needs and which lie beside the shipped one
    #[arg(long, group = "instead", conflicts_with_all = ["label", "scan", "from"])]
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
            if arguments.load || arguments.scan.is_none() {
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
    let scan = match &arguments.scan {
        Some(scan) => scan.clone(),
        None => graph::record(&label, arguments.grasps)?,
    };
    let order = Order {
        label,
        scan,
        metres_per_unit: match arguments.units {
            Units::M => 1.0,
            Units::Mm => 0.001,
        },
        out: out.clone(),
        counts: arguments.counts(),
        fit: FitSettings::default(),
        seed: arguments.seed,
    };
    let stop = stop_on_signal()?;
    let taught = teach(stored, &order, &stop)?;
    Ok(Some(Change::Taught(Box::new(taught))))
}

/// Has the running graph use a model, and compare with the reference of what was taught.
fn use_in_graph(model: &Path, reference: Option<&Path>) -> Result<()> {
    let (id, folder) = graph::load(model)?;
    program::note(format_args!(
        "the classifier answers with {id} from the next scan on"
    ));
    let (Some(reference), Some(folder)) = (reference, folder) else {
        return Ok(());
    };
    let name = reference.file_name().unwrap_or_default();
    let bytes = std::fs::read(reference);
    let copied = bytes.and_then(|bytes| whole_file::write(&folder.join(name), &bytes));
    copied.with_context(|| {
        format!(
            "cannot put {} into {}, where the node deformation looks for it; launch with references:=FOLDER of your own",
            reference.display(),
            folder.display()
        )
    })
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

fn text(taught: &Taught) -> String {
    let Taught {
        label,
        model,
        held_out,
        others_right: [before, now],
        seconds,
        ..
    } = taught;
    let mut text = format!(
        "{label}: named rightly in {:.1} % of {} held-out scans of {} views, and known in {:.1} %\n\
         what was known before: {:.1} % of the kept clouds were named rightly, now {:.1} %\n",
        100.0 * held_out.right,
        held_out.scans,
        look::VIEWS,
        100.0 * held_out.known_and_right,
        100.0 * before,
        100.0 * now,
    );
    for twin in &taught.twins {
        text += &format!("{}\n", twin.to_text(label));
    }
    text + &format!(
        "{}: {} bytes, features {} bytes, in {:.0} s\n",
        model.display(),
        taught.model_bytes,
        taught.features_bytes,
        seconds.mesh + seconds.dents + seconds.views + seconds.model,
    )
}

fn words(did: &Did) -> String {
    match did {
        Did::Teach { label, .. } => format!("teaching {label}"),
        Did::Forget { label } => format!("forgetting {label}"),
        Did::Rename { label, to } => format!("renaming {label} to {to}"),
    }
}

fn list(stored: &Stored, json: bool) -> Result<()> {
    let references = stored.references()?;
    let mut rows = Vec::new();
    let mut text = format!("{} ({})\n", stored.path.display(), stored.metadata.run_id);
    let width = stored
        .metadata
        .labels
        .iter()
        .map(String::len)
        .max()
        .unwrap_or(0);
    for label in &stored.metadata.labels {
        let step = origin_of(&stored.history, label);
        let reference = references.join(format!("{label}.ply"));
        let reference = Some(reference).filter(|path| path.is_file());
        let without = if reference.is_none() {
            "; no reference"
        } else {
            ""
        };
        let origin = match step.map(|step| (&step.did, &step.at)) {
            Some((Did::Teach { from, held_out, .. }, at)) => format!(
                "taught {at} from {from}: {:.1} % of {} held-out scans",
                100.0 * held_out.right,
                held_out.scans
            ),
            _ => "from the training".to_owned(),
        };
        text += &format!("{label:width$}  {origin}{without}\n");
        rows.push(json!({ "label": label, "taught": step, "reference": reference }));
    }
    if json {
        let described = json!({
            "model": stored.path, "run_id": stored.metadata.run_id, "labels": rows, "history": stored.history,
        });
        return program::print(format_args!("{described:#}\n"));
    }
    program::print(text)
}
