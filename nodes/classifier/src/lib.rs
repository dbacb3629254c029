//! Names the object whose cloud it gets, with a small network stored as an ONNX file
//! (paper, Sec. V and VI-C.5).
//!
//! Everything about the preprocessing comes from the model file's metadata ([`ModelMetadata`]),
//! so a model and the clouds that it was trained on cannot drift apart.

mod error;
mod extractor;
mod familiar;
mod interface;
mod metadata;
mod model;
mod preprocess;
mod provider;
mod runtime;
mod self_test;
mod session;
mod shipped;

pub use error::{ClassifyError, LoadError, MetadataError, PreprocessError, SelfTestError};
pub use extractor::Extractor;
pub use familiar::Features;
pub use metadata::{Centring, KnownBy, ModelMetadata};
pub use model::{Answer, CERTAIN_PROBABILITY, MAX_MODEL_BYTES, Model, Timing, is_known};
pub use preprocess::{preprocess, preprocess_parts};
pub use provider::{Parameters, Provider};
pub use runtime::RUNTIME_FILE;
pub use self_test::{SelfTest, TestCloud, self_test_path};
pub use session::{INPUT_NAME, KNOWN_SCORE_NAME, OUTPUT_NAME, Output};
pub use shipped::{NoShippedModel, shipped_model};
