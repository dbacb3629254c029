//! A whole training run: dataset, network, model file and a record of it all.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use classifier::ModelMetadata;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use crate::calibration::inverse_temperature;
use crate::dataset::{preprocessing, simulate};
use crate::export::{encode, write_atomically, write_model};
use crate::metrics::{Confusion, threshold_keeping};
use crate::network::Network;
use crate::samples::{Samples, read_npz, write_npz};
use crate::settings::{Settings, fingerprint};
use crate::source::{Labelled, Source};
use crate::trainer::{EpochReport, Event, log_probabilities, most_probable, train};

/// What a run achieved.
#[derive(Debug, Clone, Serialize)]
pub struct Results {
    /// Made from the settings, so that the same run has the same name.
    pub run_id: String,
    /// The model file.
    pub model: PathBuf,
    /// Its size.
    pub model_bytes: u64,
    /// Trainable values of the network.
    pub parameter_count: usize,
    /// Clouds that were learned from.
    pub train_clouds: usize,
    /// Clouds that chose the best epoch.
    pub validation_clouds: usize,
    /// Share of the validation clouds named rightly.
    pub validation_accuracy: f64,
    /// By which the logits are divided, so that probabilities are as often right as they say.
    pub temperature: f64,
    /// Score below which a cloud is called unknown.
    pub known_threshold: f64,
    /// The validation clouds' answers.
    pub confusion: Confusion,
    /// Each epoch.
    pub history: Vec<EpochReport>,
}

/// What the run is at, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Stage {
    /// Scans are being made.
    Scanning {
        /// How many specimens.
        specimens: usize,
    },
    /// One specimen is finished.
    Scanned,
    /// The network is being trained.
    Training {
        /// Steps at most.
        steps: usize,
    },
    /// One step is finished.
    Step {
        /// From 1.
        epoch: usize,
        /// Mean loss of the epoch so far.
        loss: f64,
        /// Accuracy of the epoch so far.
        accuracy: f64,
    },
    /// An epoch is finished.
    Epoch(EpochReport),
}

/// Makes or finds the dataset in `output`, trains, writes the model file, and run.yaml in a folder of `output`.
///
/// # Errors
/// A setting is impossible, a file cannot be read or written, or training fails. The model file is then as before.
pub fn run(
    settings: &Settings,
    output: &Path,
    model: &Path,
    fresh: bool,
    show: impl Fn(Stage) + Sync,
) -> Result<Results> {
    settings.validate()?;
    let run_id = format!("{}-{}", settings.seed, fingerprint(settings)?);
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    let mut metadata = preprocessing(settings.point_count, settings.centring()?);
    metadata.run_id = run_id.clone();
    let network = Network::new(settings.architecture, metadata.labels.len(), &mut random)?;
    encode(&network, 1.0, &metadata).context("the network is too large")?;

    let [train_clouds, validation] = dataset(settings, &metadata, output, fresh, &show)?;
    let history = fit(
        &network,
        [&train_clouds, &validation],
        &metadata,
        settings,
        &mut random,
        &show,
    )?;
    let judged = judge(&network, &validation, &metadata, settings)?;
    metadata.known_threshold = judged.known_threshold;
    let results = Results {
        run_id: run_id.clone(),
        model: model.to_path_buf(),
        model_bytes: write_model(model, &network, judged.inverse_temperature, &metadata)?,
        parameter_count: network.parameter_count(),
        train_clouds: train_clouds.len(),
        validation_clouds: validation.len(),
        validation_accuracy: judged.confusion.accuracy(),
        temperature: 1.0 / judged.inverse_temperature,
        known_threshold: metadata.known_threshold,
        confusion: judged.confusion,
        history,
    };
    write_record(&output.join(run_id).join("run.yaml"), settings, &results)?;
    Ok(results)
}

/// What the validation clouds of known objects say.
struct Judged {
    confusion: Confusion,
    inverse_temperature: f64,
    known_threshold: f64,
}

fn judge(
    network: &Network,
    validation: &Samples,
    metadata: &ModelMetadata,
    settings: &Settings,
) -> Result<Judged> {
    let all = log_probabilities(network, validation, metadata.metres_per_unit)?;
    let classes = metadata.labels.len();
    let mut confusion = Confusion::new(&metadata.labels);
    let (mut logits, mut labels, mut scores) = (Vec::new(), Vec::new(), Vec::new());
    for (answer, &label) in all.into_iter().zip(&validation.labels) {
        let label = label as usize;
        if label < classes {
            // Against the logit of being none of them, which is 0.
            let own: Vec<f32> = answer[..classes]
                .iter()
                .map(|l| l - answer[classes])
                .collect();
            confusion.add(label, most_probable(&own));
            scores.push(log_sum_exp(&own));
            logits.push(own);
            labels.push(label);
        }
    }
    Ok(Judged {
        confusion,
        inverse_temperature: inverse_temperature(&logits, &labels),
        known_threshold: threshold_keeping(scores, settings.known_share),
    })
}

fn log_sum_exp(logits: &[f32]) -> f64 {
    let highest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let sum: f64 = logits.iter().map(|l| f64::from(l - highest).exp()).sum();
    f64::from(highest) + sum.ln()
}

fn fit(
    network: &Network,
    clouds: [&Samples; 2],
    metadata: &ModelMetadata,
    settings: &Settings,
    random: &mut Pcg64Mcg,
    show: &impl Fn(Stage),
) -> Result<Vec<EpochReport>> {
    let parameters = &settings.training;
    let steps = parameters.epochs * clouds[0].len().div_ceil(parameters.batch_size);
    show(Stage::Training { steps });
    train(
        network,
        clouds,
        metadata.metres_per_unit,
        parameters,
        random,
        |event| {
            show(match event {
                Event::Step {
                    epoch,
                    loss,
                    accuracy,
                } => Stage::Step {
                    epoch,
                    loss,
                    accuracy,
                },
                Event::Epoch(report) => Stage::Epoch(report),
            });
            Ok(())
        },
    )
}

impl Results {
    /// A few lines for people.
    pub fn to_text(&self) -> String {
        format!(
            "{}accuracy {:.2} % on {} validation clouds (simulated scans, not trained on)\n{}: {} bytes, {} \
             parameters, run {}\n",
            self.confusion.table(),
            100.0 * self.validation_accuracy,
            self.validation_clouds,
            self.model.display(),
            self.model_bytes,
            self.parameter_count,
            self.run_id
        )
    }
}

/// Training and validation clouds, from the file of an earlier run with the same settings where there is one.
fn dataset(
    settings: &Settings,
    metadata: &ModelMetadata,
    output: &Path,
    fresh: bool,
    show: &(impl Fn(Stage) + Sync),
) -> Result<[Samples; 2]> {
    let counts = [
        settings.specimens_per_class,
        settings.validation_specimens_per_class,
    ];
    let determining = (
        settings.seed,
        counts,
        settings.strangers,
        settings.point_count,
        &settings.centring,
        &settings.scans,
    );
    let folder = output.join(format!("dataset-{}", fingerprint(&determining)?));
    let path = folder.join("clouds.npz");
    if path.is_file() && !fresh {
        let (train, validation) = read_npz(&path)?;
        return Ok([train, validation]);
    }
    let with_strangers = |count, strangers| {
        let mut labelled = Labelled::classes(count);
        labelled.push(Labelled {
            label: metadata.labels.len() as u32,
            source: Source::RandomSolids,
            count: strangers,
        });
        labelled
    };
    let parts = [
        with_strangers(counts[0], settings.strangers),
        with_strangers(counts[1], counts[1]),
    ];
    show(Stage::Scanning {
        specimens: parts.iter().flatten().map(|labelled| labelled.count).sum(),
    });
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    let mut part = |labelled: &[Labelled]| {
        let finished = || show(Stage::Scanned);
        simulate(
            labelled,
            &settings.scans,
            metadata,
            random.random(),
            finished,
        )
    };
    let (train, validation) = (part(&parts[0])?, part(&parts[1])?);
    write_npz(&path, &train, &validation)?;
    Ok([train, validation])
}

fn write_record(path: &Path, settings: &Settings, results: &Results) -> Result<()> {
    #[derive(Serialize)]
    struct Record<'a> {
        settings: &'a Settings,
        results: &'a Results,
    }
    let text = serde_yaml::to_string(&Record { settings, results })?;
    write_atomically(path, text.as_bytes())
}
