//! Makes simulated scans and trains a model on them, in one go.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use classifier::Centring;
use indicatif::ProgressBar;
use training::network::backend::Backend;
use training::network::start::Start;
use training::network::{Head, NetworkKind};
use training::progress;
use training::run::{self, Order};
use training::settings::Settings;

/// Trains a model on simulated scans of the eight objects and of your own, or on datasets of meshes seen from all sides.
///
/// The clouds go through the code of the nodes, and are kept for the next run of this program with the same settings. The
/// run's settings and results are written to run.yaml in the run's folder. Started again after an interruption, the same
/// command resumes after the last complete epoch.
#[derive(Debug, Parser)]
#[command(
    name = "train",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Where the model goes [default: model.onnx in --output]; config/model.onnx is the shipped one
    #[arg(long, value_name = "ONNX")]
    model: Option<PathBuf>,
    /// Where datasets and runs go
    #[arg(long, default_value = "target/training", value_name = "FOLDER")]
    output: PathBuf,
    /// A folder made by generate_dataset, whose objects the robot's network learns beside the eight, and the paper's network
    /// alone; may be given several times
    #[arg(long = "dataset", value_name = "FOLDER")]
    datasets: Vec<PathBuf>,
    /// Learn the objects of the datasets alone, without the eight
    #[arg(long, requires = "datasets")]
    only_datasets: bool,
    /// Which network: the robot's, or the paper's with its settings
    #[arg(long, value_name = "NAME", default_value = "robot")]
    network: NetworkKind,
    /// Give the paper's network the points' normals, too
    #[arg(long, requires = "datasets")]
    normals: bool,
    /// Let the dense layer of the paper's network see the largest of each feature, or, as the paper says, the features of all
    /// points
    #[arg(long, value_enum, default_value_t = Head::Pool)]
    head: Head,
    /// Make the clouds again, though this very program made some with these settings, and forget an interrupted run
    #[arg(long)]
    fresh: bool,
    /// Everything random comes from this
    #[arg(long)]
    seed: Option<u64>,
    /// Specimens of each class to train on
    #[arg(long)]
    specimens: Option<usize>,
    /// Solids of any form to train on beside them, so that the model learns what is none of its classes
    #[arg(long)]
    strangers: Option<usize>,
    /// Objects of the kinds of the eight and of nearly their sizes to train on as unknown, too
    #[arg(long)]
    near_strangers: Option<usize>,
    /// Share of the scans in which up to 5 mm of one side of the object are not seen
    #[arg(long, value_name = "SHARE")]
    lost_flanks: Option<f64>,
    /// N, points of a cloud that the network sees
    #[arg(long = "points", visible_alias = "point-count", value_name = "N")]
    point_count: Option<usize>,
    /// How clouds are centred: box, centroid or sphere
    #[arg(long, value_parser = parse_centring)]
    centring: Option<Centring>,
    /// F, features of a point
    #[arg(long, value_name = "F")]
    features: Option<usize>,
    /// Begin with the weights of this model, which may know fewer objects, and not with random ones
    #[arg(long, value_name = "ONNX")]
    start: Option<PathBuf>,
    /// Peak learning rate
    #[arg(long)]
    learning_rate: Option<f64>,
    /// Most epochs
    #[arg(long)]
    epochs: Option<usize>,
    /// Epochs without a better validation loss before training stops
    #[arg(long)]
    patience: Option<usize>,
    /// What runs the network: cpu, or cuda where it was built with that feature
    #[arg(long, default_value = "cpu")]
    device: Backend,
    /// Print the results as one JSON object
    #[arg(long)]
    json: bool,
}

fn parse_centring(text: &str) -> Result<Centring, String> {
    text.parse()
        .map_err(|()| format!("{text:?} is none of box, centroid and sphere"))
}

impl Arguments {
    /// The default is not the shipped model, which is replaced only on request.
    fn model(&self) -> PathBuf {
        let default = || self.output.join("model.onnx");
        self.model.clone().unwrap_or_else(default)
    }

    fn settings(&self) -> Result<Settings> {
        let mut settings = match self.network {
            NetworkKind::Robot => Settings::default(),
            NetworkKind::Paper => Settings::of_paper(),
        };
        let set = |to: &mut usize, from: Option<usize>| *to = from.unwrap_or(*to);
        settings.seed = self.seed.unwrap_or(settings.seed);
        set(&mut settings.specimens_per_class, self.specimens);
        set(&mut settings.strangers, self.strangers);
        set(&mut settings.near_strangers, self.near_strangers);
        let flanks = &mut settings.scans.flank_lost_share;
        *flanks = self.lost_flanks.unwrap_or(*flanks);
        set(&mut settings.point_count, self.point_count);
        if let Some(centring) = self.centring {
            settings.centring = centring.to_string();
        }
        if let Some(features) = self.features {
            settings.set_features(features);
        }
        settings.paper.normals = self.normals;
        settings.paper.head = self.head;
        settings.only_datasets = self.only_datasets;
        set(&mut settings.training.epochs, self.epochs);
        set(&mut settings.training.patience, self.patience);
        let rate = &mut settings.training.learning_rate;
        *rate = self.learning_rate.unwrap_or(*rate);
        settings.start = self.start.as_deref().map(Start::of).transpose()?;
        Ok(settings)
    }
}

fn main() -> ExitCode {
    program::exit_code("train", run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<()> {
    let bar = ProgressBar::new(0);
    let order = Order {
        settings: arguments.settings()?,
        datasets: arguments.datasets.clone(),
        output: arguments.output.clone(),
        model: arguments.model(),
        backend: arguments.device,
        fresh: arguments.fresh,
    };
    let results = run::run(&order, |stage| progress::show(&bar, stage))?;
    bar.finish_and_clear();
    if arguments.json {
        program::print(format_args!("{:#}\n", serde_json::to_value(&results)?))?;
    } else {
        program::print(results.to_text())?;
    }
    Ok(())
}
