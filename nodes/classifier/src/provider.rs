//! What runs the network, and the node's parameters.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use parameter::ParameterError;

/// What runs the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Provider {
    /// Intel's OpenVINO, through ONNX Runtime.
    OpenVino,
    /// ONNX Runtime's own code for the CPU.
    Cpu,
}

impl FromStr for Provider {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "openvino" => Ok(Self::OpenVino),
            "cpu" => Ok(Self::Cpu),
            _ => Err(format!(
                "{text:?} is no provider; it must be openvino or cpu"
            )),
        }
    }
}

impl fmt::Display for Provider {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenVino => "openvino",
            Self::Cpu => "cpu",
        })
    }
}

/// Parameters of the classifier.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// The model file.
    pub model: String,
    /// What runs the network; if it cannot start, the CPU does.
    pub provider: Provider,
    /// OpenVINO's device: CPU, GPU or AUTO. Without meaning for the provider `cpu`.
    pub device: String,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            model: "config/model.onnx".to_owned(),
            provider: Provider::OpenVino,
            device: "CPU".to_owned(),
        }
    }
}

impl Parameters {
    /// Checks every value.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        if self.model.trim().is_empty() {
            let allowed = "the path of an ONNX file";
            return Err(ParameterError::new(
                "model",
                format!("{:?}", self.model),
                allowed,
            ));
        }
        if !["CPU", "GPU", "AUTO"].contains(&self.device.as_str()) {
            return Err(ParameterError::new(
                "device",
                &self.device,
                "CPU, GPU or AUTO",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn defaults_are_valid() {
        Parameters::default().validate().unwrap();
    }

    #[test]
    fn a_refused_parameter_is_named_with_its_value_and_range() {
        let parameters = Parameters {
            device: "TPU".to_owned(),
            ..Parameters::default()
        };
        let message = parameters.validate().unwrap_err().to_string();
        assert_eq!(
            message,
            "parameter device is TPU; it must be CPU, GPU or AUTO"
        );
        let parameters = Parameters {
            model: String::new(),
            ..Parameters::default()
        };
        assert!(
            parameters
                .validate()
                .unwrap_err()
                .to_string()
                .contains("model")
        );
    }

    #[test]
    fn providers_read_and_write() {
        for provider in [Provider::OpenVino, Provider::Cpu] {
            assert_eq!(provider.to_string().parse::<Provider>().unwrap(), provider);
        }
        assert!("cuda".parse::<Provider>().unwrap_err().contains("cuda"));
    }
}
