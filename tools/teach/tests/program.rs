//! The program `teach` on files: teaching, `--list`, `--rename`, `--forget`, `--undo`, and bad input that it refuses.
#![allow(clippy::unwrap_used)]

mod common;

use std::path::{Path, PathBuf};

use classifier::{Model, Provider, SelfTest};
use common::{FEW, files, labels, output, refusal, spool};
use mesh::Mesh;
use mesh::file::write_ply;
use nalgebra::Isometry3;
use tempfile::TempDir;

/// A file of two cans side by side.
fn two_cans(folder: &TempDir) -> PathBuf {
    let mut mesh = Mesh::cylinder(0.03, 0.0, 0.1, 48);
    mesh.append(&mesh.transformed(&Isometry3::translation(0.08, 0.0, 0.0)));
    let path = folder.path().join("two.ply");
    write_ply(&path, &mesh).unwrap();
    path
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
