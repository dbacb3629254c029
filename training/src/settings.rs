//! Everything that determines a training run.

use anyhow::{Context, Result};
use classifier::Centring;
use parameter::{ParameterError, in_range};
use serde::{Deserialize, Serialize};

use crate::data::mesh_clouds::MeshSampling;
use crate::data::split::SplitSettings;
use crate::network::start::Start;
use crate::network::{Architecture, Head, NetworkKind, PaperArchitecture};
use crate::training::trainer::TrainingParameters;
use sim_scan::ScanParameters;

/// Everything that determines a run; the same settings give the same model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Seed of all random choices.
    pub seed: u64,
    /// Number of training specimens of each class.
    pub specimens_per_class: usize,
    /// Number of random solids to train on beside them, from which the model learns to call objects unknown.
    pub strangers: usize,
    /// Number of objects of the eight's kinds and nearly the sizes of their families to train on as unknown.
    #[serde(skip_serializing_if = "is_zero")]
    pub near_strangers: usize,
    /// Number of validation specimens of each class, and of random solids.
    pub validation_specimens_per_class: usize,
    /// N, points of a cloud that the network sees.
    pub point_count: usize,
    /// How clouds are centred: `box`, `centroid` or `sphere`.
    pub centring: String,
    /// Share of the validation clouds that the threshold of the known score accepts, 0 to 1.
    pub known_share: f64,
    /// Which network to train.
    pub network: NetworkKind,
    /// Widths of the robot's network.
    pub architecture: Architecture,
    /// Design choices of the paper's network.
    pub paper: PaperArchitecture,
    /// Parameters of the optimisation.
    pub training: TrainingParameters,
    /// Random variation of the simulated scans.
    pub scans: ScanParameters,
    /// How the meshes of a dataset become clouds.
    pub meshes: MeshSampling,
    /// Whether the robot's network learns the objects of the datasets alone, without the eight.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub only_datasets: bool,
    /// The model whose weights training begins with; random ones without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<Start>,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            specimens_per_class: 700,
            strangers: 750,
            near_strangers: 0,
            validation_specimens_per_class: 60,
            point_count: 128,
            centring: "sphere".to_owned(),
            known_share: 0.95,
            network: NetworkKind::Robot,
            architecture: Architecture::default(),
            paper: PaperArchitecture::default(),
            training: TrainingParameters::default(),
            scans: ScanParameters::default(),
            meshes: MeshSampling::default(),
            only_datasets: false,
            start: None,
        }
    }
}

impl Settings {
    /// The paper's settings: N = 62, 50 epochs of Adam without weight decay.
    pub fn of_paper() -> Self {
        let mut settings = Self {
            network: NetworkKind::Paper,
            point_count: 62,
            centring: "box".to_owned(),
            ..Self::default()
        };
        settings.training.epochs = 50;
        settings.training.patience = 50;
        settings.training.weight_decay = 0.0;
        settings
    }

    /// Sets F of the network that is trained.
    pub fn set_features(&mut self, features: usize) {
        match self.network {
            NetworkKind::Robot => self.architecture.features = features,
            NetworkKind::Paper => self.paper.features = features,
        }
    }

    /// Whether the network takes normals.
    pub fn normals(&self) -> bool {
        self.network == NetworkKind::Paper && self.paper.normals
    }

    /// Checks that every setting is in its range.
    ///
    /// # Errors
    /// Names the first setting that is not.
    pub fn validate(&self) -> Result<()> {
        self.check_ranges()?;
        self.centring()?;
        if self.paper.normals && self.network == NetworkKind::Robot {
            let allowed = "false for the robot's network; give --network paper";
            return Err(ParameterError::new("normals", true, allowed).into());
        }
        if self.paper.head == Head::Flatten && self.network == NetworkKind::Robot {
            let allowed = "pool for the robot's network; give --network paper";
            return Err(ParameterError::new("head", "flatten", allowed).into());
        }
        Ok(self.scans.registration.validate()?)
    }

    /// How datasets are split.
    pub fn split(&self) -> SplitSettings {
        SplitSettings {
            seed: self.seed,
            test_share: self.meshes.test_share,
            validation_share: self.meshes.validation_share,
        }
    }

    /// How clouds are centred.
    ///
    /// # Errors
    /// The text is none of `box`, `centroid` and `sphere`.
    pub fn centring(&self) -> Result<Centring, ParameterError> {
        let refuse =
            |()| ParameterError::new("centring", &self.centring, "box, centroid or sphere");
        self.centring.parse().map_err(refuse)
    }

    fn check_ranges(&self) -> Result<(), ParameterError> {
        let count = |name, value| in_range(name, value, 1..=1_000_000_usize, "");
        count("specimens_per_class", self.specimens_per_class)?;
        count(
            "validation_specimens_per_class",
            self.validation_specimens_per_class,
        )?;
        in_range("strangers", self.strangers, 0..=1_000_000, "")?;
        in_range("near_strangers", self.near_strangers, 0..=1_000_000, "")?;
        in_range("point_count", self.point_count, 8..=4096, "")?;
        let Architecture {
            transformer_features,
            features,
            hidden,
        } = self.architecture;
        in_range("transformer_features", transformer_features, 2..=4096, "")?;
        in_range("features", features, 2..=4096, "")?;
        in_range("features", self.paper.features, 2..=4096, "")?;
        in_range("hidden", hidden, 1..=4096, "")?;
        count("epochs", self.training.epochs)?;
        count("batch_size", self.training.batch_size)?;
        count("patience", self.training.patience)?;
        let training = &self.training;
        for (name, share) in [
            ("known_share", self.known_share),
            ("learning_rate", training.learning_rate),
            ("weight_decay", training.weight_decay),
            ("table_share", self.scans.table_share),
            ("undented_share", self.scans.undented_share),
            ("flattened_share", self.scans.flattened_share),
            ("flank_lost_share", self.scans.flank_lost_share),
            ("test_share", self.meshes.test_share),
            ("validation_share", self.meshes.validation_share),
        ] {
            in_range(name, share, 0.0..=1.0, "")?;
        }
        in_range("view_count", self.scans.view_count, 1..=100, "")?;
        let (surface_points, kept_points) = (self.meshes.surface_points, self.meshes.kept_points);
        in_range("surface_points", surface_points, 1..=1_000_000, "")?;
        in_range("kept_points", kept_points, 1..=4096, "")
    }
}

/// A short fingerprint of settings: 64-bit FNV-1a of their YAML text, in hexadecimal digits.
///
/// # Errors
/// The settings cannot be written as YAML.
pub fn fingerprint(settings: &impl Serialize) -> Result<String> {
    let text = serde_yaml::to_string(settings).context("cannot write settings")?;
    let hash = text.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    Ok(format!("{hash:016x}"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn defaults_are_valid_and_read_back_the_same() {
        let settings = Settings::default();
        settings.validate().unwrap();
        let text = serde_yaml::to_string(&settings).unwrap();
        assert_eq!(serde_yaml::from_str::<Settings>(&text).unwrap(), settings);
    }

    #[test]
    fn refused_settings_are_named() {
        let refusal = |change: fn(&mut Settings)| {
            let mut settings = Settings::default();
            change(&mut settings);
            settings.validate().unwrap_err().to_string()
        };
        let message = refusal(|settings| settings.training.epochs = 0);
        assert_eq!(
            message,
            "parameter epochs is 0; it must be from 1 to 1000000"
        );
        let message = refusal(|settings| settings.centring = "middle".to_owned());
        assert_eq!(
            message,
            "parameter centring is middle; it must be box, centroid or sphere"
        );
        assert!(refusal(|settings| settings.training.learning_rate = f64::NAN).contains("NaN"));
        let message = refusal(|settings| settings.paper.normals = true);
        assert!(message.contains("give --network paper"), "{message}");
        let message = refusal(|settings| settings.paper.head = Head::Flatten);
        assert!(message.contains("head is flatten"), "{message}");
    }

    #[test]
    fn fingerprints_differ_with_the_settings() {
        let (a, b) = (
            Settings::default(),
            Settings {
                seed: 2,
                ..Settings::default()
            },
        );
        assert_eq!(fingerprint(&a).unwrap(), fingerprint(&a.clone()).unwrap());
        assert_ne!(fingerprint(&a).unwrap(), fingerprint(&b).unwrap());
    }
}
