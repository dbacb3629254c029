//! Where the shipped model is.

use std::path::{Path, PathBuf};

/// There is no shipped model where this program looks for it.
#[derive(Debug, thiserror::Error)]
pub enum NoShippedModel {
    /// The system does not say where the program is.
    #[error("cannot tell where this program is; name a model with --model")]
    Program(#[source] std::io::Error),
    /// No such file.
    #[error("there is no model in {} nor in {}; name one with --model", .0.display(), .1.display())]
    Missing(PathBuf, PathBuf),
}

/// The shipped model: `config/model.onnx` of the checkout or of the installed package that the program is in.
///
/// # Errors
/// It is in neither.
pub fn shipped_model() -> Result<PathBuf, NoShippedModel> {
    let executable = std::env::current_exe().map_err(NoShippedModel::Program)?;
    // target/release/PROGRAM in the checkout, lib/deformable_cobot/PROGRAM where it is installed.
    let root = executable.ancestors().nth(3).unwrap_or(Path::new("/"));
    let checkout = root.join("config/model.onnx");
    let installed = root.join("share/deformable_cobot/config/model.onnx");
    if checkout.is_file() {
        Ok(checkout)
    } else if installed.is_file() {
        Ok(installed)
    } else {
        Err(NoShippedModel::Missing(checkout, installed))
    }
}
