//! What is somebody else's stays as it is; what is doubtful is said.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::process::Stdio;

use common::{QUICK, assert_same, merge, program, refusal, shards_and_whole, stderr, tree};

#[test]
fn nothing_is_touched_in_a_folder_that_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    for name in ["a.tmp", "notes.txt", "z.tmp"] {
        fs::write(out.join(name), "mine").unwrap();
    }
    let before = (tree(&out), fs::metadata(&out).unwrap().modified().unwrap());
    let said = refusal(&mut program(QUICK, &out), 1);
    assert!(
        said.contains("a.tmp") && said.contains("no dataset"),
        "{said}"
    );
    let after = (tree(&out), fs::metadata(&out).unwrap().modified().unwrap());
    assert_eq!(before, after);
}

#[test]
fn a_merge_takes_no_file_for_a_mesh_that_is_none() {
    let (_folder, [one, two, out, whole]) = shards_and_whole("out");
    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    // As a kill leaves it, and then somebody puts another file there. The meshes are links: it must be a file of its own.
    fs::remove_file(out.join("manifest.csv")).unwrap();
    let mesh = out.join("tiny-ball/0007.ply");
    fs::remove_file(&mesh).unwrap();
    fs::write(&mesh, "mine").unwrap();
    let said = refusal(&mut merge(&out, &[&one, &two]), 1);
    assert!(
        said.contains("tiny-ball/0007.ply is there already"),
        "{said}"
    );
    assert_eq!(fs::read(&mesh).unwrap(), b"mine");
    fs::remove_file(&mesh).unwrap();
    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    assert_same(&whole, &out);
}

#[test]
fn a_reader_that_has_seen_enough_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = program(QUICK, &folder.path().join("out"));
    let mut child = command
        .arg("--json")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(!stderr(&output).contains("panicked"));
}

#[test]
fn neither_is_one_that_has_heard_enough() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let code = |command: &mut std::process::Command| {
        let mut child = command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stderr.take());
        child.wait().unwrap().code()
    };
    assert_eq!(code(&mut program(QUICK, &out)), Some(0));
    assert!(out.join("manifest.csv").exists());
    assert_eq!(code(&mut program("--object blob", &out)), Some(2));
}
