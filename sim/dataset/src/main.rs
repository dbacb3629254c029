//! Makes datasets of dented objects, and joins parts of them.

use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};
use clap::{Args, Parser, Subcommand, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use sim_dataset::DatasetError;
use sim_dataset::generate::generate;
use sim_dataset::merge::merge;
use sim_dataset::object::Source;
use sim_dataset::order::{Event, Order};
use sim_dataset::settings::Settings;
use sim_dataset::shard::Shard;
use sim_dataset::summary::Summary;
use sim_objects::ObjectClass;

/// Dents objects as a gripper does, each at many grasps and several intensities.
///
/// Meshes go to OUT/OBJECT/NUMBER.ply, in millimetres, with a row each in OUT/manifest.csv; OUT/run.yaml says what
/// determines them. Started again after an interruption, it goes on; finished meshes stay as they are. The same seed,
/// sources and settings give the same bytes, whatever the number of jobs and shards.
#[derive(Debug, Parser)]
#[command(
    name = "generate_dataset",
    args_conflicts_with_subcommands = true,
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    generate: Option<GenerateArguments>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Joins all shards of a dataset into the folder that one run would have made
    ///
    /// Meshes are hard-linked, or copied to another file system; the parts stay as they are.
    Merge {
        /// Where the whole goes
        #[arg(long, value_name = "FOLDER")]
        out: PathBuf,
        /// The folders of the shards
        #[arg(required = true, value_name = "PART")]
        parts: Vec<PathBuf>,
        /// Print the results as one JSON object
        #[arg(long)]
        json: bool,
    },
}

#[derive(Debug, Args)]
struct GenerateArguments {
    /// A scan, points or mesh: PLY, PCD or OBJ; its name without the ending names the object
    #[arg(
        long = "scan",
        value_name = "FILE",
        required_unless_present = "objects"
    )]
    scans: Vec<PathBuf>,
    /// One of the parametric objects, like medium-can
    #[arg(
        long = "object",
        value_name = "NAME",
        required_unless_present = "scans"
    )]
    objects: Vec<ObjectClass>,
    /// Where the dataset goes
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Meshes of each object; by default those of 3.5 % of its graspable vertices
    #[arg(long)]
    count: Option<NonZeroUsize>,
    /// Everything random comes from this
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; by default one a core
    #[arg(long)]
    jobs: Option<NonZeroUsize>,
    /// The scans' unit
    #[arg(long, default_value = "mm")]
    units: Units,
    /// A YAML file with settings other than the defaults
    #[arg(long, value_name = "YAML")]
    settings: Option<PathBuf>,
    /// The energy that a dent minimises: as rigid as possible, or Eq. 3 of the paper letter by letter [default: rigid]
    #[arg(long, value_name = "ENERGY")]
    energy: Option<Energy>,
    /// Make only part K of N, for merge
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    /// Print the results as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Units {
    M,
    Mm,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Energy {
    Rigid,
    Laplacian,
}

impl GenerateArguments {
    fn order(&self) -> Result<Order> {
        let metres_per_unit = match self.units {
            Units::M => 1.0,
            Units::Mm => 0.001,
        };
        let scan = |file: &PathBuf| Source::Scan {
            file: file.clone(),
            metres_per_unit,
        };
        let scans = self.scans.iter().map(scan);
        let objects = self.objects.iter().copied().map(Source::Parametric);
        let jobs = self
            .jobs
            .map_or_else(std::thread::available_parallelism, Ok);
        let mut settings = match &self.settings {
            Some(file) => Settings::read(file)?,
            None => Settings::default(),
        };
        if let Some(energy) = self.energy {
            settings.dent.energy = match energy {
                Energy::Rigid => sim_deform::Energy::Rigid,
                Energy::Laplacian => sim_deform::Energy::Laplacian,
            };
        }
        Ok(Order {
            sources: scans.chain(objects).collect(),
            out: self.out.clone(),
            count: self.count,
            seed: self.seed,
            jobs: jobs.context("cannot tell the number of cores; give --jobs")?,
            shard: self.shard,
            settings,
        })
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            program::note(format_args!(
                "generate_dataset: {}",
                program::describe(error.as_ref())
            ));
            let usage = error.downcast_ref().is_some_and(DatasetError::is_usage);
            ExitCode::from(if usage { 2 } else { 1 })
        }
    }
}

fn run(arguments: Arguments) -> Result<()> {
    match (arguments.command, arguments.generate) {
        (Some(Command::Merge { out, parts, json }), _) => print(&merge(&out, &parts)?, json),
        (None, Some(arguments)) => {
            let order = arguments.order()?;
            let stop = stop_on_signal()?;
            let bar = ProgressBar::new(0);
            let summary = generate(&order, &stop, &|progress| show(&bar, progress));
            bar.finish_and_clear();
            print(&summary?, arguments.json)
        }
        (None, None) => unreachable!("clap demands one of them"),
    }
}

fn print(summary: &Summary, json: bool) -> Result<()> {
    if json {
        program::print(format_args!("{:#}\n", serde_json::to_value(summary)?))?;
    } else {
        program::print(summary.to_text())?;
    }
    Ok(())
}

/// Becomes true at the first SIGINT or SIGTERM; the second ends the program at once, which does no harm.
fn stop_on_signal() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if set.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
        program::note("generate_dataset: stopping after the meshes in work");
    })
    .context("cannot listen for signals")?;
    Ok(stop)
}

fn show(bar: &ProgressBar, event: Event) {
    match event {
        Event::Preparing { objects } => begin(bar, objects, 0, "preparing"),
        Event::Prepared => bar.inc(1),
        Event::Making { meshes, kept } => begin(bar, meshes, kept, "denting"),
        Event::Made { meshes } => advance(bar, meshes),
    }
}

fn begin(bar: &ProgressBar, length: usize, done: usize, what: &'static str) {
    let template = "{msg} [{bar:40}] {pos}/{len} {per_sec} {eta}";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.reset();
    bar.set_length(length as u64);
    bar.set_position(done as u64);
    bar.reset_eta();
    bar.set_message(what);
    if !std::io::stderr().is_terminal() {
        program::note(format_args!("{what}: {done} of {length}"));
    }
}

/// Advances the bar; without a terminal, prints a line for each tenth instead.
fn advance(bar: &ProgressBar, steps: usize) {
    let before = bar.position();
    bar.inc(steps as u64);
    let length = bar.length().unwrap_or(0).max(1);
    let tenth = |position: u64| 10 * position / length;
    let now = before + steps as u64;
    if !std::io::stderr().is_terminal() && tenth(now) > tenth(before) {
        program::note(format_args!("{now} of {length}"));
    }
}
