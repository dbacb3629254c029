//! Changes that are killed, interrupted or run out of disk: the old model stays in force, or the new one is whole.
#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use common::{FEW, files, labels, output, spool, teach};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A kill between the two renames leaves new features beside the old model; the old model stays in force then.
#[test]
fn a_change_that_is_killed_between_two_files_leaves_a_model_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let scan = spool(&folder, "thing.ply", 1.0);
    let out = folder.path().join("taught.onnx");
    let model = out.to_str().unwrap();
    let scan = scan.to_str().unwrap();
    output(&[&["my-spool", "--scan", scan, "--model", model], &FEW[..]].concat());
    for change in [&["--forget", "tiny-ball"][..], &["--undo"]] {
        let before = std::fs::read(&out).unwrap();
        let known = labels(&out);
        output(&[change, &["--model", model]].concat());
        let after = std::fs::read(&out).unwrap();
        assert_ne!(labels(&out), known);
        std::fs::write(&out, before).unwrap();
        assert_eq!(labels(&out), known, "{change:?}");
        let listed = output(&["--list", "--model", model]);
        assert_eq!(listed["labels"].as_array().unwrap().len(), known.len());
        std::fs::write(&out, after).unwrap();
    }
}

#[test]
fn a_full_disk_leaves_the_model_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let scan = spool(&folder, "thing.ply", 1.0);
    let out = folder.path().join("taught.onnx");
    let [scan, model] = [&scan, &out].map(|path| path.to_str().unwrap());
    let first = ["first", "--scan", scan, "--model", model];
    output(&[&first[..], &FEW].concat());
    let before = files(folder.path());
    let second = [&["second", "--scan", scan, "--model", model], &FEW[..]].concat();
    let sizes: BTreeSet<usize> = before.values().map(Vec::len).collect();
    println!("files of {sizes:?} bytes");
    // No file may become larger than so many kB, and the write fails as on a full disk: at the first file, or only at the new
    // features, when others are there already.
    let features = before[&out.with_extension("features")].len();
    for limit_kb in [16, features / 1024 + 1] {
        let script = format!("trap '' XFSZ; ulimit -f {limit_kb}; exec \"$0\" \"$@\"");
        let mut command = Command::new("bash");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_teach")]);
        let Output { status, stderr, .. } = command.args(&second).output().unwrap();
        let said = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(1), "{limit_kb} kB: {said}");
        for words in [
            "cannot write",
            "free space on its disk",
            "nothing has changed",
        ] {
            assert!(said.contains(words), "{limit_kb} kB: {said}");
        }
        assert!(said.contains(folder.path().to_str().unwrap()), "{said}");
        assert!(
            files(folder.path()) == before,
            "{limit_kb} kB changed a file"
        );
    }
    // A failed run leaves no folder of references for a new model: an empty one would be taken for the model's own references.
    let new = folder.path().join("new/taught.onnx");
    let words = [
        &["second", "--scan", scan, "--model", new.to_str().unwrap()],
        &FEW[..],
    ];
    let mut command = Command::new("bash");
    command.args(["-c", "trap '' XFSZ; ulimit -f 900; exec \"$0\" \"$@\""]);
    command
        .arg(env!("CARGO_BIN_EXE_teach"))
        .args(words.concat());
    assert_eq!(command.status().unwrap().code(), Some(1));
    assert!(!new.parent().unwrap().exists());
}

#[test]
fn an_interrupt_leaves_all_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let scan = spool(&folder, "thing.ply", 1.0);
    let before = files(folder.path());
    let out = folder.path().join("out.onnx");
    let words = [
        "mine",
        "--scan",
        scan.to_str().unwrap(),
        "--model",
        out.to_str().unwrap(),
    ];
    for part in ["denting it", "looking at it"] {
        let mut command = teach(&words);
        command
            .args(["--dents", "8", "--scans", "10000"])
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().starts_with(part)));
        let killed = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(killed.unwrap().success());
        let said: Vec<String> = lines.map(Result::unwrap).collect();
        assert_eq!(child.wait().unwrap().code(), Some(1));
        assert!(
            said.join("\n").contains("stopped; nothing has changed"),
            "{said:?}"
        );
        assert!(files(folder.path()) == before);
    }
}

#[test]
fn an_interrupt_at_any_moment_leaves_the_old_model_or_the_new_one() {
    let seed = std::env::var("SEED").ok();
    let seed = seed.map_or_else(rand::random, |text| text.parse().unwrap());
    println!("SEED={seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let folder = tempfile::tempdir().unwrap();
    let scan = spool(&folder, "thing.ply", 1.0);
    let out = folder.path().join("taught.onnx");
    let [scan, model] = [&scan, &out].map(|path| path.to_str().unwrap());
    let first = ["first", "--scan", scan, "--model", model];
    let start = Instant::now();
    output(&[&first[..], &FEW].concat());
    let whole = start.elapsed();
    let before = files(folder.path());
    for signal in ["-INT", "-INT", "-TERM", "-KILL", "-KILL"] {
        let words = [&["second", "--scan", scan, "--model", model], &FEW[..]];
        let mut child = teach(&words.concat())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Half of the interrupts come near the end, while the files are written.
        let share = if random.random_bool(0.5) {
            0.0..1.0
        } else {
            0.8..1.1
        };
        let moment = whole.mul_f64(random.random_range(share));
        std::thread::sleep(moment);
        let killed = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        // It may have ended before.
        killed.unwrap();
        let code = child.wait().unwrap().code();
        let after = files(folder.path());
        println!("{signal} after {moment:.2?}: exit code {code:?}");
        let listed = output(&["--list", "--model", model]);
        match (code, listed["labels"].as_array().unwrap().len()) {
            (Some(0), 10) => {}
            // Nobody is there any more to take away what was begun.
            (None, 9 | 10) if signal == "-KILL" => {}
            (Some(1) | None, 9) => assert!(after == before, "{signal} after {moment:?}"),
            other => panic!("{signal} after {moment:?}: {other:?}"),
        }
        for path in after.keys().filter(|path| !before.contains_key(*path)) {
            std::fs::remove_file(path).unwrap();
        }
        for (path, bytes) in &before {
            std::fs::write(path, bytes).unwrap();
        }
    }
}
