//! What runs the network while it is trained.

use candle_core::{Device, Result};
use serde::{Deserialize, Serialize};

/// What runs the network while it is trained.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// All cores; the same settings give the same bytes.
    #[default]
    Cpu,
    /// The first NVIDIA GPU, in programs built with the feature `cuda`. Its order of additions varies, so that models differ
    /// in their last bits.
    Cuda,
}

impl Backend {
    /// Candle's device for this backend.
    ///
    /// # Errors
    /// There is no such device, or the program was built without support for it.
    pub fn device(self) -> Result<Device> {
        match self {
            Self::Cpu => Ok(Device::Cpu),
            Self::Cuda if cfg!(feature = "cuda") => Device::new_cuda(0),
            Self::Cuda => candle_core::bail!(
                "this program was built without CUDA; build it with \
                 `cargo build --release -p training --features cuda`"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_build_without_cuda_says_how_to_get_it() {
        assert!(Backend::default().device().unwrap().is_cpu());
        if !cfg!(feature = "cuda") {
            let message = Backend::Cuda.device().unwrap_err().to_string();
            assert!(message.contains("--features cuda"), "{message}");
        }
    }
}
