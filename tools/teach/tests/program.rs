//! The program as a user runs it, on files.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;

use classifier::{Model, Provider, SelfTest};
use mesh::file::write_ply;
use mesh::{Mesh, revolve};
use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;
use tempfile::TempDir;

/// Few dents and scans: what is taught so is told badly, but in seconds.
const FEW: [&str; 4] = ["--dents", "4", "--scans", "6"];

fn teach(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_teach"));
    command.args(words).stdin(Stdio::null());
    command
}

/// The results of a run that must be good.
fn output(words: &[&str]) -> Value {
    let Output {
        status,
        stdout,
        stderr,
    } = teach(words).arg("--json").output().unwrap();
    let said = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{words:?}: {said}");
    serde_json::from_slice(&stdout).unwrap()
}

fn refusal(words: &[&str], code: i32) -> String {
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
fn spool(folder: &TempDir, name: &str, scale: f32) -> PathBuf {
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
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
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

fn labels(model: &Path) -> Vec<String> {
    let model = Model::load(model, Provider::Cpu, "CPU").unwrap();
    model.metadata().labels.clone()
}

#[test]
fn an_object_is_taught_listed_renamed_forgotten_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let scan = spool(&folder, "thing.ply", 1.0);
    let out = folder.path().join("out/taught.onnx");
    let (scan, model) = (scan.to_str().unwrap(), out.to_str().unwrap());
    let taught = output(&[&["my-spool", "--scan", scan, "--model", model], &FEW[..]].concat());
    assert!(taught["held_out"]["scans"].as_u64().unwrap() > 0);
    assert!(taught["model_bytes"].as_u64().unwrap() < 100_000);
    assert_eq!(labels(&out).len(), 9);
    let references = out.with_file_name("references");
    assert_eq!(std::fs::read_dir(&references).unwrap().count(), 9);
    assert!(references.join("my-spool.ply").is_file());
    let first = std::fs::read(&out).unwrap();
    let id = Model::load(&out, Provider::Cpu, "CPU").unwrap();
    let id = &id.metadata().run_id;
    let self_test = SelfTest::beside(&out, id).unwrap().unwrap();
    assert!(
        self_test
            .clouds
            .iter()
            .any(|cloud| cloud.label == "medium-can")
    );

    let listed = output(&["--list", "--model", model]);
    let rows = listed["labels"].as_array().unwrap();
    assert_eq!(rows[8]["label"], "my-spool");
    assert_eq!(rows[8]["taught"]["from"], "thing.ply");
    assert!(rows[0]["taught"].is_null() && rows[0]["reference"].is_string());

    let again = refusal(&["my-spool", "--scan", scan, "--model", model], 1);
    assert!(again.contains("knows my-spool already, since"), "{again}");
    assert!(again.contains("--forget my-spool"), "{again}");

    output(&["--rename", "my-spool", "reel", "--model", model]);
    assert_eq!(labels(&out)[8], "reel");
    assert!(references.join("reel.ply").is_file());
    output(&["--forget", "tiny-ball", "--model", model]);
    assert_eq!(labels(&out).len(), 8);
    let listed = output(&["--list", "--model", model]);
    assert_eq!(listed["history"].as_array().unwrap().len(), 3);
    assert_eq!(listed["labels"][7]["taught"]["label"], "my-spool");

    output(&["--undo", "--model", model]);
    output(&["--undo", "--model", model]);
    assert!(std::fs::read(&out).unwrap() == first);
    assert_eq!(SelfTest::beside(&out, id).unwrap(), Some(self_test));
    output(&["--undo", "--model", model]);
    assert_eq!(labels(&out).len(), 8);
    let nothing = refusal(&["--undo", "--model", model], 1);
    assert!(
        nothing.contains("there is no step to take back"),
        "{nothing}"
    );
}

#[test]
fn what_cannot_be_taught_is_said_with_the_remedy_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let good = spool(&folder, "good.ply", 1.0);
    let small = spool(&folder, "metres.ply", 0.001);
    let wide = spool(&folder, "wide.ply", 2.15);
    let tall = folder.path().join("tall.ply");
    write_ply(&tall, &Mesh::cylinder(0.03, 0.0, 0.3, 48).subdivided()).unwrap();
    let open = folder.path().join("flat.ply");
    cloud::write_ply(&open, &[[0.0; 3].into(), [0.1, 0.0, 0.0].into()]).unwrap();
    let two = two_cans(&folder);
    let empty = folder.path().join("empty.ply");
    cloud::write_ply(&empty, &[]).unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/model.onnx");
    let bare = folder.path().join("bare.onnx");
    std::fs::copy(&shipped, &bare).unwrap();
    let damaged = folder.path().join("damaged.onnx");
    std::fs::copy(&shipped, &damaged).unwrap();
    std::fs::write(damaged.with_extension("features"), "no features").unwrap();
    let before = files(folder.path());
    let out = folder.path().join("out.onnx");
    let out = out.to_str().unwrap();
    let refused = |words: &[&str], expected: &[&str]| {
        let said = refusal(words, 1);
        for part in expected {
            assert!(said.contains(part), "{words:?}: {said}");
        }
        assert!(files(folder.path()) == before, "{words:?} changed a file");
    };
    let with = |label: &str, scan: &Path, expected: &[&str]| {
        refused(
            &[label, "--scan", scan.to_str().unwrap(), "--model", out],
            expected,
        );
    };
    with(
        "medium-can",
        &good,
        &[
            "knows medium-can already, from its training",
            "--forget medium-can",
        ],
    );
    with("my spool", &good, &["\"my spool\" cannot name an object"]);
    with("mine", Path::new("absent.ply"), &["absent.ply"]);
    with("mine", &open, &["flat", "scan again"]);
    with("mine", &small, &["0.0001 m long", "--units"]);
    with(
        "mine",
        &wide,
        &["0 places", "gripper opens to 0.114 m", "--units"],
    );
    with(
        "mine",
        &two,
        &["2 objects are in view, more than 8 mm from each other; show one alone"],
    );
    with("mine", &empty, &["empty.ply"]);
    with("mine", &tall, &["300 mm high", "roi_crop/height_m"]);
    let [bare, damaged] = [&bare, &damaged].map(|path| path.to_str().unwrap());
    let scan = good.to_str().unwrap();
    for model in [bare, damaged] {
        let words = ["mine", "--scan", scan, "--model", out, "--from", model];
        refused(&words, &[&format!("teach --prepare --model {model}")]);
    }
    refused(
        &["--list", "--model", out, "--from", "absent.onnx"],
        &["absent.onnx"],
    );
    refused(
        &["--forget", "teapot", "--model", out],
        &["does not know teapot", "medium-can"],
    );
    refused(
        &["--rename", "medium-can", "food-can", "--model", out],
        &["knows food-can already"],
    );
    let blocked = good.join("out.onnx");
    refused(
        &[
            "--forget",
            "medium-can",
            "--model",
            blocked.to_str().unwrap(),
        ],
        &["cannot write", "is there space", "nothing has changed"],
    );
    refusal(&[], 2);
    refusal(&["--list", "--undo"], 2);
}

/// Where the features are replaced and the model is not yet, the model of before stays in force.
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

/// A file of two cans side by side.
fn two_cans(folder: &TempDir) -> PathBuf {
    let mut mesh = Mesh::cylinder(0.03, 0.0, 0.1, 48);
    mesh.append(&mesh.transformed(&Isometry3::translation(0.08, 0.0, 0.0)));
    let path = folder.path().join("two.ply");
    write_ply(&path, &mesh).unwrap();
    path
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
    // For a new model, not even a folder is left: an empty one of references would count as one.
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
