//! Adapts a trained model to other objects: the layers after its pooled features are fitted again, to features of the new
//! object and to those that were kept of what it knew. No old cloud is needed.
//!
//! [`Kept`] is the file of features, [`Head`] are the layers, and [`fit()`] fits them.

mod beside;
pub mod calibration;
mod familiar;
mod fit;
mod head;
mod kept;
mod minimise;

pub use beside::{FeaturesError, copy_path, features_of, features_path, read_features};
pub use familiar::Familiar;
pub use fit::{Change, FitSettings, fit};
pub use head::{
    FEATURES, Head, HeadError, Layer, inverse_temperature_of, set_inverse_temperature,
    with_features,
};
pub use kept::{Block, FeatureRows, KEPT_MAX, Kept, KeptError, STRANGERS};
