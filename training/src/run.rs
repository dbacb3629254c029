//! A whole training run: dataset, network, model file and a record of it all.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use classifier::ModelMetadata;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use crate::code;
use crate::data::simulate::preprocessing;
use crate::data::source::{Data, Source};
use crate::evaluation::TestResult;
use crate::evaluation::answers::Answers;
use crate::evaluation::confusion::Confusion;
use crate::kept;
use crate::network::backend::Backend;
use crate::network::export::{encode, write_model, write_whole};
use crate::network::{Network, NetworkKind};
use crate::progress::Stage;
use crate::references;
use crate::settings::Settings;
use crate::training::checkpoint::Checkpoint;
use crate::training::epoch::EpochReport;
use crate::training::trainer::train;

/// The order for a training run.
#[derive(Debug, Clone)]
pub struct Order {
    /// Everything that determines the run, except the datasets.
    pub settings: Settings,
    /// Dataset folders to train on; may be empty for the robot's network.
    pub datasets: Vec<PathBuf>,
    /// Folder for clouds and runs.
    pub output: PathBuf,
    /// Path of the model file.
    pub model: PathBuf,
    /// What runs the network.
    pub backend: Backend,
    /// Whether to ignore cached clouds and an interrupted run.
    pub fresh: bool,
}

/// Results of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Results {
    /// Fingerprint of settings and data: the same run has the same name.
    pub run_id: String,
    /// Path of the model file.
    pub model: PathBuf,
    /// Size of the model file.
    pub model_bytes: u64,
    /// Number of trainable parameters.
    pub parameter_count: usize,
    /// Number of training clouds.
    pub train_clouds: usize,
    /// Number of validation clouds.
    pub validation_clouds: usize,
    /// Share of right answers about the validation clouds.
    pub validation_accuracy: f64,
    /// T of temperature scaling: the logits are divided by it.
    pub temperature: f64,
    /// Known score (negative energy) below which a cloud is called unknown.
    pub known_threshold: f64,
    /// Confusion matrix of the validation clouds.
    pub confusion: Confusion,
    /// Result on the test set, which only datasets of meshes have.
    pub test: Option<TestResult>,
    /// Losses and accuracies of each epoch.
    pub history: Vec<EpochReport>,
}

/// Makes the clouds or finds them in `output`, trains, writes the model file, what `teach` needs and the undented objects beside it, and run.yaml in a folder of `output`. An interrupted run resumes after its last complete epoch and ends with the same bytes. Clouds and unfinished runs of other
/// code are not reused.
///
/// # Errors
/// A setting is out of range, a file cannot be read or written, or training fails. The model file is then unchanged.
pub fn run(order: &Order, show: impl Fn(Stage) + Sync) -> Result<Results> {
    let settings = &order.settings;
    settings.validate()?;
    let source = Source::open(settings, &order.datasets)?;
    let run_id = run_id(settings, &source)?;
    let folder = order.output.join(&run_id);
    let mut metadata = preprocessing(settings.point_count, settings.centring()?);
    metadata.labels = source.labels();
    metadata.normals = settings.normals();
    metadata.run_id = run_id.clone();
    metadata.trained_on = Some(source.trained_on(settings).to_text()?);
    let network = network(settings, metadata.labels.len())?;
    if let Some(start) = &settings.start {
        start.put_into(&network, &metadata.labels)?;
    }
    let network = network.on(&order.backend.device()?)?;
    metadata.network_version = network.version().to_owned();
    encode(&network, 1.0, &metadata).context("the network is too large")?;

    let data = source.data(settings, &metadata, &order.output, order.fresh, &show)?;
    let _lock = lock(&folder)?;
    let checkpoint = folder.join("checkpoint.safetensors");
    let checkpoint = Checkpoint::new(checkpoint, &metadata.labels, code::digest()?);
    if order.fresh {
        checkpoint.remove()?;
    }
    let history = fit(&network, &data, &metadata, settings, &checkpoint, &show)?;
    let answers = Answers::of(&network, &data.validation, &metadata)?;
    let inverse_temperature = answers.inverse_temperature();
    metadata.known_threshold = answers.threshold(settings.known_share);
    let test = data.test.as_ref().map(|part| -> Result<TestResult> {
        let answers = Answers::of(&network, part, &metadata)?;
        Ok(answers.test(&metadata, inverse_temperature))
    });
    let confusion = answers.confusion(&metadata.labels);
    let results = Results {
        run_id,
        model: order.model.clone(),
        model_bytes: write_model(&order.model, &network, inverse_temperature, &metadata)?,
        parameter_count: network.parameter_count(),
        train_clouds: data.train.labels.len(),
        validation_clouds: data.validation.labels.len(),
        validation_accuracy: confusion.accuracy(),
        temperature: 1.0 / inverse_temperature,
        known_threshold: metadata.known_threshold,
        confusion,
        test: test.transpose()?,
        history,
    };
    if let Some(clouds) = &data.kept {
        let made = format!("train, run {}", results.run_id);
        kept::write(&order.model, clouds, made)?;
    }
    references::write(&order.model, &metadata.labels, &order.datasets)?;
    write_record(&folder.join("run.yaml"), order, &results)?;
    checkpoint.remove()?;
    Ok(results)
}

/// The name of a run with these settings on this data.
///
/// # Errors
/// The settings cannot be written as YAML.
pub fn run_id(settings: &Settings, source: &Source) -> Result<String> {
    Ok(format!(
        "{}-{}",
        settings.seed,
        source.fingerprint(settings)?
    ))
}

/// Locks the run's folder until the file is dropped: another run with the same settings would write the same files.
fn lock(folder: &Path) -> Result<File> {
    let path = folder.join("lock");
    let unlocked = std::fs::create_dir_all(folder).and_then(|()| File::create(&path));
    let file = unlocked.with_context(|| format!("cannot write {}", path.display()))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => bail!(
            "another training with the same settings is at work in {}; wait for it, or give another --output or --seed",
            folder.display()
        ),
        Err(TryLockError::Error(error)) => {
            Err(error).with_context(|| format!("cannot lock {}", path.display()))
        }
    }
}

fn network(settings: &Settings, classes: usize) -> Result<Network> {
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    Ok(match settings.network {
        NetworkKind::Robot => Network::robot(settings.architecture, classes, &mut random)?,
        NetworkKind::Paper => {
            Network::paper(settings.paper, settings.point_count, classes, &mut random)?
        }
    })
}

fn fit(
    network: &Network,
    data: &Data,
    metadata: &ModelMetadata,
    settings: &Settings,
    checkpoint: &Checkpoint,
    show: &impl Fn(Stage),
) -> Result<Vec<EpochReport>> {
    let parameters = &settings.training;
    let steps = parameters.epochs * data.train.labels.len().div_ceil(parameters.batch_size);
    show(Stage::Training { steps });
    let observe = |event| {
        show(Stage::Trained(event));
        Ok(())
    };
    train(
        network,
        [&data.train, &data.validation],
        metadata.metres_per_unit,
        parameters,
        settings.seed,
        Some(checkpoint),
        observe,
    )
}

impl Results {
    /// A few lines for people.
    pub fn to_text(&self) -> String {
        let (confusion, accuracy, clouds, what) = match &self.test {
            Some(test) => {
                let what = "test clouds (meshes of grasps that had no part in training)";
                (&test.confusion, test.accuracy, test.clouds, what)
            }
            None => {
                let what = "validation clouds (simulated scans, not trained on)";
                (
                    &self.confusion,
                    self.validation_accuracy,
                    self.validation_clouds,
                    what,
                )
            }
        };
        format!(
            "{}accuracy {:.2} % on {clouds} {what}\n{}: {} bytes, {} parameters, run {}\n",
            confusion.table(),
            100.0 * accuracy,
            self.model.display(),
            self.model_bytes,
            self.parameter_count,
            self.run_id
        )
    }
}

fn write_record(path: &Path, order: &Order, results: &Results) -> Result<()> {
    #[derive(Serialize)]
    struct Record<'a> {
        commit: &'a str,
        code: String,
        settings: &'a Settings,
        datasets: &'a [PathBuf],
        backend: Backend,
        results: &'a Results,
    }
    let text = serde_yaml::to_string(&Record {
        commit: sim_dataset::record::COMMIT,
        code: code::digest()?,
        settings: &order.settings,
        datasets: &order.datasets,
        backend: order.backend,
        results,
    })?;
    write_whole(path, text.as_bytes())
}
