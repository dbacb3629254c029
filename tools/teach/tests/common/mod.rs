//! Runs the program as a user does, on files.
#![allow(clippy::unwrap_used, dead_code)] // Each test file uses a part.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use classifier::{Model, Provider};
use mesh::file::write_ply;
use mesh::revolve;
use serde_json::Value;
use tempfile::TempDir;

/// Few dents and scans: what is taught so is told badly, but in seconds.
pub const FEW: [&str; 4] = ["--dents", "4", "--scans", "6"];

/// The command that runs `teach` with these arguments.
pub fn teach(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_teach"));
    command.args(words).stdin(Stdio::null());
    command
}

/// The results of a run that must be good.
pub fn output(words: &[&str]) -> Value {
    let Output {
        status,
        stdout,
        stderr,
    } = teach(words).arg("--json").output().unwrap();
    let said = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{words:?}: {said}");
    serde_json::from_slice(&stdout).unwrap()
}

/// What a run says that must end with this code.
pub fn refusal(words: &[&str], code: i32) -> String {
    let output = teach(words).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{words:?}: {said}");
    assert!(
        output.stdout.is_empty() && !said.contains("panicked"),
        "{said}"
    );
    said
}

/// A spool whose outline is cut into steps that a finger pad can dent.
pub fn spool(folder: &TempDir, name: &str, scale: f32) -> PathBuf {
    let radius = |z: f32| {
        if (20.0..80.0).contains(&z) {
            28.0
        } else {
            40.0
        }
    };
    let mut outline = vec![[0.0, 0.0]];
    outline.extend((0..=25).map(|k| 4.0 * k as f32).map(|z| [radius(z), z]));
    outline.push([0.0, 100.0]);
    let outline: Vec<[f32; 2]> = outline
        .into_iter()
        .map(|p: [f32; 2]| p.map(|mm| scale * mm / 1000.0))
        .collect();
    let path = folder.path().join(name);
    write_ply(&path, &revolve(&outline, 64)).unwrap();
    path
}

/// The files of a folder and of those in it, with their bytes.
pub fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(self::files(&path));
        } else {
            files.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
    files
}

/// What a model knows.
pub fn labels(model: &Path) -> Vec<String> {
    let model = Model::load(model, Provider::Cpu, "CPU").unwrap();
    model.metadata().labels.clone()
}
