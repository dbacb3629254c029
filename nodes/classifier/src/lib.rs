//! Names the object whose cloud it gets, with a small network stored as an ONNX file
//! (paper, Sec. V and VI-C.5).
//!
//! Everything about the preprocessing comes from the model file's metadata ([`ModelMetadata`]),
//! so a model and the clouds that it was trained on cannot drift apart.

mod error;
mod extractor;
mod metadata;
mod model;
mod preprocess;
mod provider;
mod runtime;
mod session;
mod shipped;

pub use error::{ClassifyError, LoadError, MetadataError, PreprocessError};
pub use extractor::Extractor;
pub use metadata::{Centring, ModelMetadata};
pub use model::{Answer, CERTAIN_PROBABILITY, MAX_MODEL_BYTES, Model, Timing, is_known};
pub use preprocess::{preprocess, preprocess_parts};
pub use provider::{Parameters, Provider};
pub use runtime::RUNTIME_FILE;
pub use session::{INPUT_NAME, KNOWN_SCORE_NAME, OUTPUT_NAME, Output};
pub use shipped::{NoShippedModel, shipped_model};
