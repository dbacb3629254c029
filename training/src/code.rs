//! Identifies this program's code, so that clouds and weights made by other code are not reused.

use std::fs;
use std::sync::OnceLock;

use anyhow::{Context, Result};
use sim_dataset::digest::hex_digest;

/// SHA-256 of this program's executable: it changes with every change of the code that makes clouds and weights, the nodes'
/// libraries included.
///
/// # Errors
/// The system does not let the program read its own file.
pub fn digest() -> Result<String> {
    static DIGEST: OnceLock<String> = OnceLock::new();
    if let Some(digest) = DIGEST.get() {
        return Ok(digest.clone());
    }
    // Read by the kernel's link: a rebuild may have replaced the file since the program was started.
    let program = fs::read("/proc/self/exe").context("cannot read this program's own file")?;
    let digest = hex_digest(&program)[..16].to_owned();
    Ok(DIGEST.get_or_init(|| digest).clone())
}
