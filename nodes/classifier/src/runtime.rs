//! Finds and loads ONNX Runtime's shared library, once a process.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use ort::environment::Environment;

use crate::error::LoadError;

/// Name of ONNX Runtime's library. Its providers' libraries must lie beside it.
pub const RUNTIME_FILE: &str = "libonnxruntime.so.1.24.1";

/// The environment variable that overrules the search.
const PATH_VARIABLE: &str = "ORT_DYLIB_PATH";

/// The process's ONNX Runtime; loaded by the first call.
///
/// # Errors
/// The library is nowhere, or does not load; every later call gets the same error.
pub fn environment() -> Result<&'static Environment, LoadError> {
    static ENVIRONMENT: OnceLock<Result<Environment, String>> = OnceLock::new();
    let environment = ENVIRONMENT.get_or_init(|| {
        let executable = std::env::current_exe().map_err(|error| error.to_string())?;
        let overruling = std::env::var_os(PATH_VARIABLE).map(PathBuf::from);
        let library = find_library(overruling.as_deref(), &executable)?;
        load(&library).map_err(|error| format!("cannot load {}: {error}", library.display()))
    });
    environment.as_ref().map_err(|reason| LoadError::Runtime {
        reason: reason.clone(),
    })
}

/// `overruling` if given, else the first of these that exists:
/// `../onnxruntime/` from the executable's folder (`target/release` → `target/onnxruntime`;
/// installed: `lib/deformable_cobot` → `lib/onnxruntime`), then `../../onnxruntime/` (test
/// executables in `target/release/deps`).
fn find_library(overruling: Option<&Path>, executable: &Path) -> Result<PathBuf, String> {
    if let Some(path) = overruling {
        if path.is_file() {
            return Ok(path.to_path_buf());
        }
        return Err(format!(
            "{PATH_VARIABLE} is {}, which is no file; let it name {RUNTIME_FILE}, or unset it",
            path.display()
        ));
    }
    let parents = executable.ancestors().skip(2).take(2);
    let places: Vec<PathBuf> = parents
        .map(|folder| folder.join("onnxruntime").join(RUNTIME_FILE))
        .collect();
    if let Some(found) = places.iter().find(|place| place.is_file()) {
        return Ok(found.clone());
    }
    let places: Vec<String> = places.iter().map(|p| p.display().to_string()).collect();
    Err(format!(
        "the library is not in {}; run `make build`, which fetches it, or let {PATH_VARIABLE} \
         name it",
        places.join(" nor in ")
    ))
}

fn load(library: &Path) -> Result<Environment, String> {
    let builder = ort::init_from(library).map_err(|error| error.to_string())?;
    builder
        .with_name("classifier")
        .with_telemetry(false)
        .with_logger(Arc::new(|level, category, _id, place, message| {
            log::log!(target: "onnxruntime", log_level(level), "{category} {place}: {message}");
        }))
        .build()
        .map_err(|error| error.to_string())
}

/// A failing provider is reported by our own message; ONNX Runtime's words are details of it.
fn log_level(level: ort::logging::LogLevel) -> log::Level {
    use ort::logging::LogLevel;
    match level {
        LogLevel::Fatal => log::Level::Error,
        LogLevel::Error => log::Level::Warn,
        LogLevel::Warning => log::Level::Info,
        _ => log::Level::Trace,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_library_is_found_beside_the_executables_folder() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("onnxruntime");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join(RUNTIME_FILE), "").unwrap();
        for executable in ["release/classifier", "release/deps/classifier-0a1b"] {
            let found = find_library(None, &root.path().join(executable)).unwrap();
            assert_eq!(found, folder.join(RUNTIME_FILE));
        }
    }

    #[test]
    fn a_missing_library_names_the_places_and_the_remedy() {
        let message = find_library(None, Path::new("/nowhere/release/classifier")).unwrap_err();
        assert!(
            message.contains("/nowhere/onnxruntime/libonnxruntime.so"),
            "{message}"
        );
        assert!(message.contains("make build"), "{message}");
        let missing = Some(Path::new("/nowhere/x.so"));
        let message = find_library(missing, Path::new("/a/b/c")).unwrap_err();
        assert!(
            message.contains("ORT_DYLIB_PATH is /nowhere/x.so"),
            "{message}"
        );
    }
}
