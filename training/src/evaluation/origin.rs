//! What a figure comes from.

use std::num::NonZeroUsize;

use classifier::Model;
use serde::{Deserialize, Serialize};
use sim_dataset::digest::hex_digest;
use sim_dataset::record::COMMIT;

/// Everything that determines a measurement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The commit that this program was built from; `-dirty` where files had changed.
    pub commit: String,
    /// The training run that made the model.
    pub model_id: String,
    /// Which network it is.
    pub network: String,
    /// What ran it.
    pub provider: String,
    /// Specimens of each class.
    pub specimens: usize,
    /// Everything random comes from this.
    pub seed: u64,
    /// SHA-256 of all that the network was given, in its order.
    pub data_digest: String,
}

impl Origin {
    pub(crate) fn of(model: &Model, specimens: NonZeroUsize, seed: u64, digest: Digest) -> Self {
        let metadata = model.metadata();
        Self {
            commit: COMMIT.to_owned(),
            model_id: metadata.run_id.clone(),
            network: metadata.network_version.clone(),
            provider: model.provider().to_owned(),
            specimens: specimens.get(),
            seed,
            data_digest: hex_digest(&digest.bytes),
        }
    }

    /// One line.
    pub fn to_text(&self) -> String {
        let Self {
            commit,
            model_id,
            network,
            provider,
            specimens,
            seed,
            data_digest,
        } = self;
        format!(
            "model {model_id} ({network}), {provider}; commit {commit}; seed {seed}, {specimens} specimens a class; data {}",
            data_digest.get(..16).unwrap_or(data_digest)
        )
    }
}

/// Collects what the network is given.
#[derive(Debug, Default)]
pub(crate) struct Digest {
    bytes: Vec<u8>,
}

impl Digest {
    pub fn add(&mut self, input: &[f32]) {
        self.bytes
            .extend(input.iter().flat_map(|value| value.to_le_bytes()));
    }
}
