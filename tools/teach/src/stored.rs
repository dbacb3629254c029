//! A model on disk: the ONNX file with its history, and the file of kept features beside it.

use std::io::Write;
use std::path::{Path, PathBuf};

use adaptation::{
    Block, FEATURES, Head, Kept, features_path, inverse_temperature_of, set_inverse_temperature,
    with_features,
};
use anyhow::{Context, Result, bail, ensure};
use classifier::{Extractor, Model, ModelMetadata, Provider};
use onnx_file::ModelBuilder;
use sim_dataset::digest::hex_digest;
use sim_dataset::folder::REFERENCES;
use whole_file::Draft;

use crate::history::{HISTORY, Step};

/// A model that can be taught.
#[derive(Debug, Clone)]
pub struct Stored {
    /// Its file.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub digest: String,
    /// What the file says about itself.
    pub metadata: ModelMetadata,
    /// What was taught to it, the first step first.
    pub history: Vec<Step>,
    /// The layers that can be fitted again.
    pub head: Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// Features of what it knows.
    pub kept: Kept,
    bytes: Vec<u8>,
    builder: ModelBuilder,
}

/// What a change makes of a model.
#[derive(Debug, Clone)]
pub struct Changed {
    /// The new layers.
    pub head: Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// Threshold of the known score.
    pub known_threshold: f64,
    /// A block for each label in order, and one of strangers.
    pub blocks: Vec<Block>,
    /// What was done.
    pub step: Step,
}

/// A file to be written with a model.
#[derive(Debug, Clone)]
pub struct Beside {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub bytes: Vec<u8>,
}

/// Sizes of what was written, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// Of the model file.
    pub model: usize,
    /// Of the features beside it.
    pub features: usize,
}

impl Stored {
    /// Reads a model and the features beside it.
    ///
    /// # Errors
    /// The model cannot be used, is not the robot's network, or has no features; the last two with the remedy.
    pub fn open(path: &Path) -> Result<Self> {
        let Unprepared {
            path,
            digest,
            metadata,
            head,
            bytes,
            builder,
        } = Unprepared::open(path)?;
        let in_model = || format!("model {}", path.display());
        let history = match builder.metadata_of(HISTORY) {
            None => Vec::new(),
            Some(text) => serde_json::from_str(text)
                .with_context(|| format!("the history in {} is damaged", path.display()))?,
        };
        let kept = kept_of(&path, &digest)?;
        let names = metadata.labels.iter().map(|label| Some(label.as_str()));
        ensure!(
            names
                .chain([None])
                .eq(kept.blocks.iter().map(|block| block.label.as_deref()))
                && kept.width == head.features(),
            "{} has features of other labels than the model; {}",
            features_path(&path).display(),
            remedy(&path)
        );
        let inverse_temperature = inverse_temperature_of(&builder).with_context(in_model)?;
        Ok(Self {
            inverse_temperature,
            path,
            digest,
            metadata,
            history,
            head,
            kept,
            bytes,
            builder,
        })
    }

    /// What computes features of clouds.
    ///
    /// # Errors
    /// ONNX Runtime refuses the network.
    pub fn extractor(&self) -> Result<Extractor> {
        extractor(&self.builder, &self.metadata, &self.path)
    }

    /// The folder of the undented objects of what the model knows: beside it, else the shipped one.
    ///
    /// # Errors
    /// The system does not say where this program is.
    pub fn references(&self) -> Result<PathBuf> {
        references_of(&self.path)
    }

    /// Writes the changed model to `out`: the model, its features, what is given beside it, and copies of the model and
    /// features of before, to which [`crate::change::undo`] goes back. The model comes last, and all of it whole: where one
    /// cannot be written, nothing has changed.
    ///
    /// # Errors
    /// A file cannot be written, or the new model cannot be loaded.
    pub fn write(&self, changed: &Changed, out: &Path, beside: Vec<Beside>) -> Result<Sizes> {
        let mut builder = self.builder.clone();
        changed.head.put_into(&mut builder);
        set_inverse_temperature(&mut builder, changed.inverse_temperature);
        let labels = changed
            .blocks
            .iter()
            .filter_map(|block| block.label.clone());
        builder.set_metadata("labels", &labels.collect::<Vec<_>>().join(","));
        builder.set_metadata("known_threshold", &changed.known_threshold.to_string());
        let mut history = self.history.clone();
        history.push(changed.step.clone());
        builder.set_metadata(HISTORY, &serde_json::to_string(&history)?);
        builder.set_metadata("run_id", &self.next_id(&builder, history.len()));
        let model = builder.encode();
        let kept = Kept {
            model: hex_digest(&model),
            made: self.kept.made.clone(),
            width: self.kept.width,
            blocks: changed.blocks.clone(),
        };
        let features = kept.encode()?;
        let sizes = Sizes {
            model: model.len(),
            features: features.len(),
        };
        let mut files = self.copies(out)?;
        files.extend(beside);
        files.push(Beside {
            path: features_path(out),
            bytes: features,
        });
        files.push(Beside {
            path: out.to_path_buf(),
            bytes: model,
        });
        write_together(&files)?;
        Ok(sizes)
    }

    /// The id of before, the number of the step and a part of the new file's digest.
    fn next_id(&self, builder: &ModelBuilder, step: usize) -> String {
        let first = self.metadata.run_id.split('/').next().unwrap_or_default();
        let digest = hex_digest(&builder.clone().encode());
        format!("{first}/{step}-{}", &digest[..8])
    }

    /// Copies of this model and its features, to go back to.
    fn copies(&self, out: &Path) -> Result<Vec<Beside>> {
        let model = copy_path(out, &self.digest);
        let features = Beside {
            path: features_path(&model),
            bytes: self.kept.encode()?,
        };
        let model = Beside {
            path: model,
            bytes: self.bytes.clone(),
        };
        Ok(vec![features, model])
    }
}

/// A model without its features.
#[derive(Debug, Clone)]
pub struct Unprepared {
    /// Its file.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub digest: String,
    /// What the file says about itself.
    pub metadata: ModelMetadata,
    /// The layers that can be fitted again.
    pub head: Head,
    bytes: Vec<u8>,
    builder: ModelBuilder,
}

impl Unprepared {
    /// Reads a model.
    ///
    /// # Errors
    /// The model cannot be used, or is not the robot's network.
    pub fn open(path: &Path) -> Result<Self> {
        let metadata = Model::load(path, Provider::Cpu, "CPU")?.metadata().clone();
        let bytes =
            std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let in_model = || format!("model {}", path.display());
        let builder = ModelBuilder::decode(&bytes).with_context(in_model)?;
        Ok(Self {
            head: Head::of(&builder).with_context(in_model)?,
            path: path.to_path_buf(),
            digest: hex_digest(&bytes),
            metadata,
            bytes,
            builder,
        })
    }

    /// What computes features of clouds.
    ///
    /// # Errors
    /// ONNX Runtime refuses the network.
    pub fn extractor(&self) -> Result<Extractor> {
        extractor(&self.builder, &self.metadata, &self.path)
    }
}

fn extractor(model: &ModelBuilder, metadata: &ModelMetadata, path: &Path) -> Result<Extractor> {
    let bytes = with_features(model)?;
    Ok(Extractor::new(&bytes, metadata, FEATURES, path)?)
}

/// The folder of the undented objects of what a model knows: beside it, else the shipped one.
///
/// # Errors
/// The system does not say where this program is.
pub fn references_of(model: &Path) -> Result<PathBuf> {
    let beside = model.with_file_name(REFERENCES);
    if beside.is_dir() {
        return Ok(beside);
    }
    Ok(deformation::shipped_references()?)
}

/// Where a model of before is kept, by the digest of its file: MODEL.before/DIGEST.onnx.
pub fn copy_path(model: &Path, digest: &str) -> PathBuf {
    model
        .with_extension("before")
        .join(format!("{digest}.onnx"))
}

/// The features beside a model, or those that were kept when they were replaced and the model was not.
fn kept_of(model: &Path, digest: &str) -> Result<Kept> {
    let path = features_path(model);
    let kept = read_kept(&path, model)?;
    if kept.model == digest {
        return Ok(kept);
    }
    let copy = features_path(&copy_path(model, digest));
    if copy.is_file() {
        return read_kept(&copy, model);
    }
    bail!(
        "{} belongs to another model than {}; {}",
        path.display(),
        model.display(),
        remedy(model)
    )
}

fn read_kept(path: &Path, model: &Path) -> Result<Kept> {
    if !path.is_file() {
        bail!(
            "{} has no features of what it knows beside it ({}); {}",
            model.display(),
            path.display(),
            remedy(model)
        );
    }
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    Kept::decode(&bytes).with_context(|| format!("{}: {}", path.display(), remedy(model)))
}

fn remedy(model: &Path) -> String {
    format!(
        "make them: rosrun deformable_cobot teach --prepare --model {}",
        model.display()
    )
}

/// Writes all files whole, and under their names only once each of them is on the disk. The last one must be a model, which
/// is loaded before.
pub(crate) fn write_together(files: &[Beside]) -> Result<()> {
    let mut drafts = Vec::with_capacity(files.len());
    for Beside { path, bytes } in files {
        let draft = || -> std::io::Result<Draft> {
            if let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) {
                std::fs::create_dir_all(folder)?;
            }
            let mut draft = Draft::of(path)?;
            draft.file().write_all(bytes)?;
            draft.file().sync_all()?;
            Ok(draft)
        };
        let draft = draft().with_context(|| {
            format!(
                "cannot write {}; is there space, and may you write there? Nothing has changed",
                path.display()
            )
        })?;
        drafts.push((draft, path));
    }
    if let Some((model, _)) = drafts.last() {
        Model::load(model.path(), Provider::Cpu, "CPU").context("the new model cannot be used")?;
    }
    for (draft, path) in drafts {
        draft
            .finish()
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}
