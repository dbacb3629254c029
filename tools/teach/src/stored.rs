//! A model on disk: the ONNX file with its history, and the file of kept features beside it.

use std::path::{Path, PathBuf};

use adaptation::{
    Block, Familiar, Head, Kept, copy_path, features_of, features_path, inverse_temperature_of,
    set_inverse_temperature,
};
use anyhow::{Context, Result, ensure};
use classifier::{Extractor, KnownBy, ModelMetadata, SelfTest, TestCloud, self_test_path};
use onnx_file::ModelBuilder;
use sim_dataset::digest::hex_digest;
use sim_dataset::folder::REFERENCES;

use crate::history::{HISTORY, Step};
use crate::judge::Judge;
pub use crate::together::Beside;
use crate::together::write_together;
pub use crate::unprepared::Unprepared;
use crate::unprepared::extractor;

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
    /// What gives the known score; the network itself without it.
    pub familiar: Option<Familiar>,
    /// Clouds that it names rightly; none where there is no self-test beside it.
    pub self_test: Vec<TestCloud>,
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
    /// What gives that score.
    pub known_by: KnownBy,
    /// A block for each label in order, and one of strangers.
    pub blocks: Vec<Block>,
    /// Clouds for the self-test; what the new model does not name rightly is left out.
    pub self_test: Vec<TestCloud>,
    /// What was done.
    pub step: Step,
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
        let history = history_of(&builder, &path)?;
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
        let self_test = SelfTest::beside(&path, &metadata.run_id)?;
        Ok(Self {
            self_test: self_test.unwrap_or_default().clouds,
            inverse_temperature,
            familiar: match metadata.known_by {
                KnownBy::Features => Familiar::of_known(&kept.blocks),
                KnownBy::Network => None,
            },
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

    /// What judges answers of this model.
    pub fn judge(&self) -> Judge<'_> {
        Judge {
            head: &self.head,
            inverse_temperature: self.inverse_temperature,
            familiar: self.familiar.as_ref(),
            known_threshold: self.metadata.known_threshold,
        }
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

    /// Writes the changed model to `out`: the model, its features and self-test, what is given beside it, and copies of the model and
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
        let metadata = ModelMetadata {
            labels: labels.collect(),
            known_threshold: changed.known_threshold,
            known_by: changed.known_by,
            ..self.metadata.clone()
        };
        for (key, value) in metadata.to_entries() {
            builder.set_metadata(key, &value);
        }
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
        write_together(&files, &changed.self_test)?;
        Ok(sizes)
    }

    /// The id of before, the number of the step and a part of the new file's digest.
    fn next_id(&self, builder: &ModelBuilder, step: usize) -> String {
        let first = self.metadata.run_id.split('/').next().unwrap_or_default();
        let digest = hex_digest(&builder.clone().encode());
        format!("{first}/{step}-{}", &digest[..8])
    }

    /// Copies of this model and its features, to go back to.
    pub(crate) fn copies(&self, out: &Path) -> Result<Vec<Beside>> {
        let model = copy_path(out, &self.digest);
        let features = Beside {
            path: features_path(&model),
            bytes: self.kept.encode()?,
        };
        let test = SelfTest {
            model_id: self.metadata.run_id.clone(),
            clouds: self.self_test.clone(),
        };
        let test = Beside {
            path: self_test_path(&model),
            bytes: test.encode()?,
        };
        let model = Beside {
            path: model,
            bytes: self.bytes.clone(),
        };
        Ok(vec![features, test, model])
    }
}

/// What was taught to the model of this file, the first step first.
///
/// # Errors
/// It is damaged.
pub fn history_of(model: &ModelBuilder, path: &Path) -> Result<Vec<Step>> {
    match model.metadata_of(HISTORY) {
        None => Ok(Vec::new()),
        Some(text) => serde_json::from_str(text)
            .with_context(|| format!("the history in {} is damaged", path.display())),
    }
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

fn kept_of(model: &Path, digest: &str) -> Result<Kept> {
    features_of(model, digest).with_context(|| {
        format!(
            "{} has no usable features of what it knows beside it; {}",
            model.display(),
            remedy(model)
        )
    })
}

fn remedy(model: &Path) -> String {
    format!(
        "make them: rosrun deformable_cobot teach --prepare --model {}",
        model.display()
    )
}
