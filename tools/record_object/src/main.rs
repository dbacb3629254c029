//! Makes a mesh of the object in the hand, for a dataset of it.

use anyhow::Result;
use clap::{Parser, ValueEnum};
use msg::deformable_cobot::ScanObjectFeedback;
use node::Node;
use record_object::{Grasps, Motion, Order, Screen, Target, record};
use scan::bar::{Bar, Viewer};
use scan::program;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

/// Makes a mesh of the object in the hand, from which generate_dataset makes dented ones to train on.
///
/// The wrist turns it through its whole range. Then put it back upside down and press Enter: the second grasp shows what
/// the fingers hid in the first. The mesh goes to NAME.ply, in millimetres, +z up. Ctrl-C ends it and waits until the arm
/// is still.
#[derive(Debug, Parser)]
#[command(
    name = "record_object",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Name of the object; later it is the label
    name: String,
    /// How often the object is grasped; auto: a second time only where the first shows too little of it
    #[arg(long, value_enum, default_value_t = Times::Two)]
    grasps: Times,
    /// Views of each grasp during one sweep of the wrist through so many radians; 6 is the whole range
    #[arg(long, value_name = "RAD", default_value_t = 6.0)]
    range: f64,
    /// So many views of each grasp, at rest for each, in place of a sweep
    #[arg(long, value_name = "N", conflicts_with = "range", value_parser = clap::value_parser!(u32).range(1..))]
    views: Option<u32>,
    /// The folder that the mesh goes to
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    save: PathBuf,
    /// Replace a mesh of that name
    #[arg(long)]
    force: bool,
    /// Print what was made as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Times {
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
    Auto,
}

fn main() -> ExitCode {
    program::run("record_object", run)
}

async fn run(node: Node, arguments: Arguments) -> Result<()> {
    let name = &arguments.name;
    let order = Order {
        // What cannot be saved is said before the arm moves.
        target: Target::new(&arguments.save, name, arguments.force)?,
        grasps: match arguments.grasps {
            Times::One => Grasps::One,
            Times::Two => Grasps::Two,
            Times::Auto => Grasps::AsNeeded,
        },
        motion: match arguments.views {
            Some(views) => Motion::Views(views),
            None => Motion::Sweep(arguments.range),
        },
    };
    let made = record(&node, &order, &Terminal::default()).await?;
    let scan = made.file.display();
    let next =
        format!("rosrun deformable_cobot generate_dataset --scan {scan} --out {name} --count 300");
    if arguments.json {
        let mut described = made.to_json();
        described["object"] = name.as_str().into();
        described["next"] = next.into();
        return program::print(format_args!("{described:#}\n"));
    }
    program::print(format_args!("next: {next}\n"))
}

/// A bar for each scan, and lines between them.
#[derive(Default)]
struct Terminal(Mutex<Option<Bar>>);

impl Terminal {
    fn with(&self, act: impl FnOnce(&Bar)) {
        let bar = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = &*bar {
            act(bar);
        }
    }

    fn replace(&self, new: Option<Bar>) {
        let mut bar = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(old) = std::mem::replace(&mut *bar, new) {
            old.clear();
        }
    }
}

impl Viewer for Terminal {
    fn show(&self, report: &ScanObjectFeedback) {
        self.with(|bar| bar.show(report));
    }

    fn say(&self, words: &'static str) {
        self.with(|bar| bar.say(words));
    }
}

impl Screen for Terminal {
    fn begin(&self) {
        self.replace(Some(Bar::default()));
    }

    fn end(&self) {
        self.replace(None);
    }

    fn note(&self, line: &str) {
        program::note(line);
    }
}
