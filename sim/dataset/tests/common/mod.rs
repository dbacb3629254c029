//! Runs the program as a user does, and looks at what it leaves.
#![allow(clippy::unwrap_used, dead_code)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A quick dataset: two objects, the second of which ends with a grasp that has not all intensities.
pub const QUICK: &str = "--object tiny-ball --object small-cup --count 20 --seed 7";

/// The program with words as arguments, then the folder of the dataset.
pub fn program(words: &str, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_generate_dataset"));
    let words = words.split_whitespace();
    command
        .args(words)
        .arg("--out")
        .arg(out)
        .stdin(Stdio::null());
    command
}

/// Runs to the end, which must be good.
pub fn run(words: &str, out: &Path) {
    let output = program(words, out).output().unwrap();
    assert!(output.status.success(), "{words}: {}", stderr(&output));
}

/// Runs to an end with this exit code; returns what the program said.
pub fn refusal(command: &mut Command, code: i32) -> String {
    let output = command.output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{command:?}: {said}");
    assert!(output.stdout.is_empty(), "{command:?} printed results");
    assert!(!said.contains("panicked"), "{said}");
    said
}

/// Paths with these names in a new folder.
pub fn places<const N: usize>(names: [&str; N]) -> (tempfile::TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().unwrap();
    let places = names.map(|name| folder.path().join(name));
    (folder, places)
}

/// The folders of both shards of the quick dataset, of one that is still to be made, and of the whole.
pub fn shards_and_whole(empty: &str) -> (tempfile::TempDir, [PathBuf; 4]) {
    let (folder, folders) = places(["one", "two", empty, "whole"]);
    run(&format!("{QUICK} --shard 1/2"), &folders[0]);
    run(&format!("{QUICK} --shard 2/2"), &folders[1]);
    run(QUICK, &folders[3]);
    (folder, folders)
}

/// Joins parts.
pub fn merge(out: &Path, parts: &[&Path]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_generate_dataset"));
    command.arg("merge").arg("--out").arg(out).args(parts);
    command
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// All files below a folder by their path in it, with their bytes.
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                files.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// Fails with the names of the files that differ, not with their bytes.
pub fn assert_same(a: &Path, b: &Path) {
    let (a_files, b_files) = (tree(a), tree(b));
    let names = a_files.keys().chain(b_files.keys());
    let different: Vec<_> = names
        .filter(|name| a_files.get(*name) != b_files.get(*name))
        .collect();
    assert!(
        different.is_empty(),
        "{a:?} and {b:?} differ: {different:?}"
    );
}
