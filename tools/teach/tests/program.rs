//! The program as a user runs it, on files.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use classifier::{Model, Provider, SelfTest};
use mesh::file::write_ply;
use mesh::{Mesh, revolve};
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
        &["cannot write", "is there space", "Nothing has changed"],
    );
    refusal(&[], 2);
    refusal(&["--list", "--undo"], 2);
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
        assert!(lines.any(|line| line.unwrap() == part));
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
