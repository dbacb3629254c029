//! Which meshes a model was not trained on: its file names the datasets that it was trained on and how they were split.

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::clouds::Split;
use super::mesh_dataset::{MeshDataset, MeshFile};
use super::split::{SplitSettings, split};

/// The datasets that a model was trained on, beside randomly generated objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainedOn {
    /// SHA-256 of the manifest of each dataset folder, and so of every byte of its meshes.
    pub manifests: Vec<String>,
    /// How each class's meshes were split.
    pub split: SplitSettings,
}

/// The meshes of a dataset that may be measured on, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unseen {
    /// The model was trained on other datasets: all meshes.
    All,
    /// It was trained on this one: only those that were held out.
    HeldOut,
    /// The model file does not say what it was trained on: all meshes, some of which it may know.
    Unknown,
}

impl TrainedOn {
    /// The JSON text of the model file's entry.
    ///
    /// # Errors
    /// A share is NaN or infinite.
    pub fn to_text(&self) -> Result<String> {
        Ok(serde_json::to_string(self)?)
    }

    fn from_text(text: &str) -> Result<Self> {
        serde_json::from_str(text)
            .context("the model file does not say what it was trained on as this version writes it")
    }
}

/// The meshes of a dataset that a model with this entry of its file has not seen, nor was chosen by.
///
/// # Errors
/// The entry is damaged, or the dataset cannot be split as it was.
pub fn unseen(dataset: &MeshDataset, trained_on: Option<&str>) -> Result<(Vec<MeshFile>, Unseen)> {
    let Some(trained_on) = trained_on.map(TrainedOn::from_text).transpose()? else {
        return Ok((dataset.meshes.clone(), Unseen::Unknown));
    };
    let is_known = |manifest: &String| trained_on.manifests.contains(manifest);
    if !dataset.manifests.iter().any(is_known) {
        return Ok((dataset.meshes.clone(), Unseen::All));
    }
    let split = split(dataset, &trained_on.split)?;
    let pairs = dataset.meshes.iter().zip(split);
    let held_out = pairs.filter(|(_, split)| *split == Split::Test);
    Ok((
        held_out.map(|(mesh, _)| mesh.clone()).collect(),
        Unseen::HeldOut,
    ))
}
