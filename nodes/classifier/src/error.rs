//! What can go wrong, each with the thing's name and what to do.

use std::path::PathBuf;

use thiserror::Error;

/// Why a model's metadata was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MetadataError {
    /// The key is not in the file.
    #[error("metadata key `{key}` is missing; write the model with `train`")]
    Missing {
        /// The key.
        key: &'static str,
    },
    /// The key is there with a value that makes no sense.
    #[error("metadata key `{key}` is {value:?}; it must be {allowed}")]
    Wrong {
        /// The key.
        key: &'static str,
        /// Its value.
        value: String,
        /// What would have been accepted.
        allowed: &'static str,
    },
}

/// Why a model did not load.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error("cannot read model {}", path.display())]
    Read {
        /// The model file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file has an impossible size.
    #[error("model {} has {bytes} bytes; a model has 1 to {max}", path.display())]
    Size {
        /// The model file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The largest size.
        max: u64,
    },
    /// ONNX Runtime's library is not where it is looked for, or does not load.
    #[error("ONNX Runtime: {reason}")]
    Runtime {
        /// What was tried and what to do.
        reason: String,
    },
    /// ONNX Runtime refuses the file.
    #[error("model {} is not a usable ONNX file: {reason}", path.display())]
    Corrupt {
        /// The model file.
        path: PathBuf,
        /// ONNX Runtime's words.
        reason: String,
    },
    /// The network's inputs or outputs are not those of the contract.
    #[error("model {}: {what} is {found}; it must be {expected}", path.display())]
    Interface {
        /// The model file.
        path: PathBuf,
        /// Which input or output.
        what: &'static str,
        /// What the file has.
        found: String,
        /// What the contract asks for.
        expected: String,
    },
    /// The metadata is incomplete or wrong.
    #[error("model {}", path.display())]
    Metadata {
        /// The model file.
        path: PathBuf,
        /// The key and what is wrong with it.
        source: MetadataError,
    },
    /// The features that tell what is known cannot be read.
    #[error(
        "model {} tells what is known by the features beside it, {}, and they cannot be used: {reason}; keep both files \
         together, or make the features: teach --prepare --model {}",
        path.display(), features.display(), path.display()
    )]
    Features {
        /// The model file.
        path: PathBuf,
        /// The features' file.
        features: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The self-test beside the model cannot be read, or the model fails it.
    #[error("self-test {}", path.display())]
    SelfTest {
        /// The self-test's file.
        path: PathBuf,
        /// What is wrong.
        source: SelfTestError,
    },
}

/// Why a model does not pass its self-test.
#[derive(Debug, Error)]
pub enum SelfTestError {
    /// The file cannot be read.
    #[error("it cannot be read: {0}; make it again: teach --prepare")]
    Unreadable(String),
    /// A cloud gets another name.
    #[error("the model takes cloud {number} of {count}, a {label}, for {found}")]
    Wrong {
        /// Number of the cloud, from 1.
        number: usize,
        /// Of how many.
        count: usize,
        /// What it is of.
        label: String,
        /// What the model says.
        found: String,
    },
    /// A cloud is not of the network's size, or the network failed.
    #[error("the network cannot be run on its clouds")]
    Run(#[from] ClassifyError),
}

/// Why a cloud could not be made into the network's input.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PreprocessError {
    /// The cloud has fewer points than the network takes, or one that is not finite.
    #[error("the object cloud cannot be sampled")]
    Sample(#[from] cloud::SampleError),
    /// The up direction has no direction.
    #[error("the up direction {0:?} has no length")]
    NoUp([f64; 3]),
}

/// Why a cloud got no name.
#[derive(Debug, Error)]
pub enum ClassifyError {
    /// The cloud does not fit the network.
    #[error(transparent)]
    Preprocess(#[from] PreprocessError),
    /// ONNX Runtime failed.
    #[error("inference failed: {0}")]
    Inference(String),
    /// The network answered with something that is no set of probabilities.
    #[error("the network answered {0}; the model file is damaged")]
    Output(String),
}
