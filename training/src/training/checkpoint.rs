//! Checkpoints: the state of training in one file, replaced as a whole after each epoch, to resume after an interruption.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor, safetensors};
use whole_file::Draft;

use crate::training::epoch::EpochReport;
use crate::training::optimizer::AdamState;

/// Everything that the next epoch depends on, apart from settings and data: its random numbers depend on the seed and the
/// epoch's number alone.
#[derive(Debug, Clone)]
pub struct State {
    /// The network's weights.
    pub weights: Vec<Tensor>,
    /// The weights of the epoch with the lowest validation loss.
    pub best_weights: Vec<Tensor>,
    /// The optimiser's state.
    pub adam: AdamState,
    /// Reports of the epochs so far.
    pub history: Vec<EpochReport>,
}

/// The checkpoint file of an unfinished training, in safetensors format.
#[derive(Debug, Clone)]
pub struct Checkpoint {
    path: PathBuf,
    labels: String,
    code: String,
}

const LABELS: &str = "labels";
const CODE: &str = "code";
const HISTORY: &str = "history";
const STEPS: &str = "steps";
const GROUPS: [&str; 4] = ["weight", "best", "mean", "square"];
/// Columns of the history: loss and accuracy of training, then of validation, and whether it was the best.
const COLUMNS: usize = 5;

impl Checkpoint {
    /// A checkpoint at this path, for a network with these labels and code with this digest. The file is not touched.
    pub fn new(path: PathBuf, labels: &[String], code: String) -> Self {
        let labels = labels.join(",");
        Self { path, labels, code }
    }

    /// Writes a state; the previous one stays until this one is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, state: &State) -> Result<()> {
        let write = || -> Result<()> {
            fs::create_dir_all(self.path.parent().unwrap_or(Path::new(".")))?;
            let draft = Draft::of(&self.path)?;
            safetensors::save(&self.tensors(state)?, draft.path())?;
            Ok(draft.finish()?)
        };
        write().with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// Reads the state, if there is one. A state written by other code counts as none: a training done partly by one code
    /// and partly by another could not be reproduced.
    ///
    /// # Errors
    /// The file is damaged, or of a network with other labels or another shape than `like`.
    pub fn read(&self, like: &[Tensor]) -> Result<Option<State>> {
        if !self.path.exists() {
            return Ok(None);
        }
        self.parse(like).with_context(|| {
            let path = self.path.display();
            format!("cannot go on from {path}; --fresh starts anew")
        })
    }

    /// Removes the file, if there is one.
    ///
    /// # Errors
    /// The file cannot be removed.
    pub fn remove(&self) -> Result<()> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(error).with_context(|| format!("cannot remove {}", self.path.display()))
            }
            _ => Ok(()),
        }
    }

    fn tensors(&self, state: &State) -> Result<HashMap<String, Tensor>> {
        let rows = state.history.iter().flat_map(|report| {
            let best = f64::from(u8::from(report.best));
            let [train, validation] = [
                [report.train_loss, report.train_accuracy],
                [report.validation_loss, report.validation_accuracy],
            ];
            [train[0], train[1], validation[0], validation[1], best]
        });
        let device = &Device::Cpu;
        let shape = (state.history.len(), COLUMNS);
        let history = Tensor::from_vec(rows.collect::<Vec<f64>>(), shape, device)?;
        let labels = Tensor::new(self.labels.as_bytes(), device)?;
        let steps = Tensor::new(&[state.adam.steps as i64], device)?;
        let mut tensors = HashMap::from([
            (HISTORY.to_owned(), history),
            (LABELS.to_owned(), labels),
            (CODE.to_owned(), Tensor::new(self.code.as_bytes(), device)?),
            (STEPS.to_owned(), steps),
        ]);
        let lists = [
            &state.weights,
            &state.best_weights,
            &state.adam.means,
            &state.adam.squares,
        ];
        for (group, list) in GROUPS.into_iter().zip(lists) {
            let named = list.iter().enumerate();
            tensors.extend(named.map(|(index, tensor)| (name(group, index), tensor.clone())));
        }
        Ok(tensors)
    }

    fn parse(&self, like: &[Tensor]) -> Result<Option<State>> {
        let tensors = safetensors::load(&self.path, &Device::Cpu)?;
        let code = tensors.get(CODE).map(|code| code.to_vec1::<u8>());
        if code.transpose()?.as_deref() != Some(self.code.as_bytes()) {
            return Ok(None);
        }
        let get = |name: &str| {
            tensors
                .get(name)
                .with_context(|| format!("it has no {name}"))
        };
        let labels = String::from_utf8_lossy(&get(LABELS)?.to_vec1::<u8>()?).into_owned();
        ensure!(
            labels == self.labels,
            "it knows the labels {labels}, and the data has {}",
            self.labels
        );
        let list = |group: &str| -> Result<Vec<Tensor>> {
            let one = |(index, like): (usize, &Tensor)| {
                let name = name(group, index);
                let tensor = get(&name)?;
                let (there, here) = (tensor.dims(), like.dims());
                ensure!(
                    there == here,
                    "{name} is {there:?}, and the network's is {here:?}"
                );
                Ok(tensor.clone())
            };
            like.iter().enumerate().map(one).collect()
        };
        let [weights, best_weights, means, squares] = GROUPS.map(list);
        let steps = get(STEPS)?.to_vec1::<i64>()?;
        let steps = *steps.first().context("it has no steps")?;
        Ok(Some(State {
            weights: weights?,
            best_weights: best_weights?,
            adam: AdamState {
                steps: usize::try_from(steps)?,
                means: means?,
                squares: squares?,
            },
            history: history(get(HISTORY)?)?,
        }))
    }
}

fn name(group: &str, index: usize) -> String {
    format!("{group}.{index:02}")
}

fn history(rows: &Tensor) -> Result<Vec<EpochReport>> {
    let rows = rows.to_vec2::<f64>()?.into_iter().enumerate();
    let report = |(index, row): (usize, Vec<f64>)| match row[..] {
        [
            train_loss,
            train_accuracy,
            validation_loss,
            validation_accuracy,
            best,
        ] => Ok(EpochReport {
            epoch: index + 1,
            train_loss,
            train_accuracy,
            validation_loss,
            validation_accuracy,
            best: best > 0.0,
        }),
        _ => anyhow::bail!("its history has {} columns", row.len()),
    };
    rows.map(report).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn tensors(value: f32) -> Vec<Tensor> {
        [2, 3]
            .map(|size| Tensor::full(value, size, &Device::Cpu).unwrap())
            .to_vec()
    }

    fn state() -> State {
        State {
            weights: tensors(1.0),
            best_weights: tensors(2.0),
            adam: AdamState {
                steps: 7,
                means: tensors(3.0),
                squares: tensors(4.0),
            },
            history: vec![EpochReport {
                epoch: 1,
                train_loss: 0.1,
                train_accuracy: 0.2,
                validation_loss: 0.3,
                validation_accuracy: 0.4,
                best: true,
            }],
        }
    }

    fn labels(names: [&str; 2]) -> Vec<String> {
        names.map(str::to_owned).to_vec()
    }

    #[test]
    fn a_state_reads_back_the_same_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run/checkpoint.safetensors");
        let checkpoint = Checkpoint::new(path.clone(), &labels(["a", "b"]), "code".to_owned());
        assert!(checkpoint.read(&tensors(0.0)).unwrap().is_none());
        checkpoint.write(&state()).unwrap();
        let read = checkpoint.read(&tensors(0.0)).unwrap().unwrap();
        assert_eq!(format!("{read:?}"), format!("{:?}", state()));
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        let other = Checkpoint::new(path.clone(), &labels(["a", "b"]), "other".to_owned());
        assert!(other.read(&tensors(0.0)).unwrap().is_none());
        checkpoint.remove().unwrap();
        checkpoint.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn a_damaged_file_and_other_labels_or_layers_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        let checkpoint = Checkpoint::new(path.clone(), &labels(["a", "b"]), "code".to_owned());
        checkpoint.write(&state()).unwrap();
        let refusal = |labels: &[String], like: &[Tensor]| {
            let read = Checkpoint::new(path.clone(), labels, "code".to_owned()).read(like);
            program::describe(read.unwrap_err().as_ref())
        };
        let message = refusal(&labels(["a", "c"]), &tensors(0.0));
        assert!(
            message.contains("the labels a,b, and the data has a,c"),
            "{message}"
        );
        let message = refusal(&labels(["a", "b"]), &tensors(0.0)[1..]);
        assert!(
            message.contains("is [2], and the network's is [3]"),
            "{message}"
        );
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() - 5]).unwrap();
        let message = refusal(&labels(["a", "b"]), &tensors(0.0));
        assert!(message.contains("--fresh starts anew"), "{message}");
    }
}
