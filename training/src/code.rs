//! Which code this program is, so that nothing that other code made is taken for its own.

use std::fs;
use std::sync::OnceLock;

use anyhow::{Context, Result};
use sim_dataset::digest::hex_digest;

/// Digest of this program's own file: it changes with every change of the code that clouds and weights come from, the
/// nodes' included.
///
/// # Errors
/// The system does not let the program read its own file.
pub fn digest() -> Result<String> {
    static DIGEST: OnceLock<String> = OnceLock::new();
    if let Some(digest) = DIGEST.get() {
        return Ok(digest.clone());
    }
    // The kernel's own link: the file may have been replaced since the program was started.
    let program = fs::read("/proc/self/exe").context("cannot read this program's own file")?;
    let digest = hex_digest(&program)[..16].to_owned();
    Ok(DIGEST.get_or_init(|| digest).clone())
}
