//! Settings of making meshes, apart from sources, count and seed.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::DatasetError;

/// How meshes are made; the same settings give the same meshes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Intensities of each grasp, m, ascending: each dent starts from the one before (paper Sec. IV-B 7).
    pub intensities_m: Vec<f64>,
    /// How a scan becomes a mesh.
    pub reconstruct: sim_reconstruct::Settings,
    /// How a mesh is dented.
    pub dent: sim_deform::Settings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            intensities_m: vec![0.004, 0.006, 0.008, 0.010, 0.012, 0.014],
            reconstruct: sim_reconstruct::Settings::default(),
            dent: sim_deform::Settings::default(),
        }
    }
}

impl Settings {
    /// Reads a YAML file; settings that it leaves out have the values of [`Settings::default`].
    ///
    /// # Errors
    /// The file cannot be read, has an unknown key or a value out of range.
    pub fn read(file: &Path) -> Result<Self, DatasetError> {
        let text = std::fs::read_to_string(file).map_err(DatasetError::io("read", file))?;
        let refuse = |reason| DatasetError::Settings {
            file: file.to_path_buf(),
            reason,
        };
        let settings: Self =
            serde_yaml::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        settings.check().map_err(refuse)?;
        Ok(settings)
    }

    fn check(&self) -> Result<(), String> {
        let intensities = &self.intensities_m;
        let rising = intensities.windows(2).all(|pair| pair[0] < pair[1]);
        let in_range = intensities
            .iter()
            .all(|&intensity_m| intensity_m > 0.0 && intensity_m <= 0.1);
        if intensities.is_empty() || !rising || !in_range {
            return Err(format!(
                "intensities_m is {intensities:?}; it must be rising, above 0 and at most 0.1"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn read(text: &str) -> Result<Settings, DatasetError> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Settings::read(file.path())
    }

    #[test]
    fn defaults_are_valid_and_read_back_the_same() {
        let settings = Settings::default();
        let text = serde_yaml::to_string(&settings).unwrap();
        assert_eq!(read(&text).unwrap(), settings);
        assert_eq!(read("{}").unwrap(), settings);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_by_name() {
        for (text, named) in [
            ("intensities_m: []", "intensities_m"),
            ("intensities_m: [0.004, 0.004]", "rising"),
            ("intensities_m: [.nan]", "intensities_m"),
            ("intensities_m: [4, 6]", "at most 0.1"),
            ("intensity: 1", "intensity"),
            ("dent: {arapp: 1}", "arapp"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(named), "{text}: {message}");
        }
    }
}
