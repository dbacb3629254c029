//! What tells whether bytes are the same.

use sha2::{Digest, Sha256};

/// SHA-256 as text.
pub fn hex_digest(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
