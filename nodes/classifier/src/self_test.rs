//! Clouds that a model must name rightly before it is used: the file `MODEL.selftest.json` beside it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{ClassifyError, LoadError, SelfTestError};
use crate::model::{CERTAIN_PROBABILITY, Model};

/// Values of a cloud in the file are whole numbers of this part of the network's unit, which is a tenth of a millimetre
/// for the robot's network.
const STEPS_PER_UNIT: f32 = 1000.0;

/// Clouds of each label.
const OF_EACH: usize = 2;

/// Where the self-test of a model is: beside its file, with the ending `.selftest.json`.
pub fn self_test_path(model: &Path) -> PathBuf {
    model.with_extension("selftest.json")
}

/// Test clouds, each with its expected label. A model that names one of them wrongly is refused when it is loaded.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfTest {
    /// The `run_id` of the model that they are for.
    pub model_id: String,
    /// The clouds.
    pub clouds: Vec<TestCloud>,
}

/// One cloud.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TestCloud {
    /// What it is of.
    pub label: String,
    /// The network's input, shape `[3, N]`, in thousandths.
    input: Vec<i32>,
}

impl TestCloud {
    /// Of an input as [`crate::preprocess`] makes it.
    pub fn of(label: &str, input: &[f32]) -> Self {
        let whole = input
            .iter()
            .map(|value| (value * STEPS_PER_UNIT).round() as i32);
        Self {
            label: label.to_owned(),
            input: whole.collect(),
        }
    }

    /// The network's input.
    pub fn input(&self) -> Vec<f32> {
        let values = self.input.iter();
        values.map(|&value| value as f32 / STEPS_PER_UNIT).collect()
    }
}

impl SelfTest {
    /// For a model: of each label the first two of the clouds that it names rightly and with certainty.
    ///
    /// # Errors
    /// A cloud is not of the network's size, or the network failed.
    pub fn of(model: &mut Model, clouds: &[TestCloud]) -> Result<Self, ClassifyError> {
        let mut test = Self {
            model_id: model.metadata().run_id.clone(),
            clouds: Vec::new(),
        };
        for cloud in clouds {
            let chosen = test
                .clouds
                .iter()
                .filter(|other| other.label == cloud.label);
            if chosen.count() < OF_EACH {
                let (label, probability) = model.name(&cloud.input())?;
                if label == cloud.label && probability >= CERTAIN_PROBABILITY {
                    test.clouds.push(cloud.clone());
                }
            }
        }
        Ok(test)
    }

    /// The self-test beside a model; `None` where there is none, or it is for another model.
    ///
    /// # Errors
    /// The file is there and cannot be read.
    pub fn beside(model: &Path, model_id: &str) -> Result<Option<Self>, LoadError> {
        let path = self_test_path(model);
        if !path.is_file() {
            return Ok(None);
        }
        let failed = |reason: String| LoadError::SelfTest {
            path: path.clone(),
            source: SelfTestError::Unreadable(reason),
        };
        let bytes = std::fs::read(&path).map_err(|error| failed(error.to_string()))?;
        let test: Self =
            serde_json::from_slice(&bytes).map_err(|error| failed(error.to_string()))?;
        Ok(Some(test).filter(|test| test.model_id == model_id))
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// They cannot be written as JSON.
    pub fn encode(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec(self)
    }

    /// Whether the model names all of them rightly.
    ///
    /// # Errors
    /// It does not, with the first cloud's label; or the network failed.
    pub fn try_on(&self, model: &mut Model) -> Result<(), SelfTestError> {
        for (number, cloud) in self.clouds.iter().enumerate() {
            let (found, _) = model.name(&cloud.input())?;
            if found != cloud.label {
                return Err(SelfTestError::Wrong {
                    number: number + 1,
                    count: self.clouds.len(),
                    label: cloud.label.clone(),
                    found,
                });
            }
        }
        Ok(())
    }
}
