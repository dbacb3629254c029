//! Ends the build where ROS's message definitions are missing: the message crate would be built without them, and say nothing.

use std::collections::BTreeMap;
use std::path::Path;

/// Folders of packages, separated by colons; a package that may be in one of several places is named several times.
const PATH: &str = "ROSRUST_MSG_PATH";

fn main() {
    println!("cargo::rerun-if-env-changed={PATH}");
    println!("cargo::rerun-if-changed=build.rs");
    let path = std::env::var(PATH).unwrap_or_default();
    let mut found: BTreeMap<&str, bool> = BTreeMap::new();
    for folder in path.split(':') {
        let package = folder.rsplit('/').next().unwrap_or(folder);
        *found.entry(package).or_default() |= Path::new(folder).is_dir();
    }
    let missing: Vec<&str> = found
        .into_iter()
        .filter_map(|(package, is_there)| (!is_there).then_some(package))
        .collect();
    if !missing.is_empty() {
        println!(
            "cargo::error=ROS's message definitions are missing: {}. Run `make setup`, then build again",
            missing.join(", ")
        );
    }
}
