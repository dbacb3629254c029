//! The same order gives the same bytes: whatever the jobs, the shards and the interruptions.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{QUICK, assert_same, merge, places, program, run, stderr, tree};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

#[test]
fn jobs_do_not_change_a_byte() {
    let folder = tempfile::tempdir().unwrap();
    let one = folder.path().join("one");
    run(&format!("{QUICK} --jobs 1"), &one);
    for jobs in [2, 5] {
        let several = folder.path().join(jobs.to_string());
        run(&format!("{QUICK} --jobs {jobs}"), &several);
        assert_same(&one, &several);
    }
    let files = tree(&one);
    let meshes = files
        .keys()
        .filter(|name| name.extension().unwrap() == "ply" && !name.starts_with("references"));
    assert_eq!(meshes.count(), 40);
    let rows = String::from_utf8(files[Path::new("manifest.csv")].clone()).unwrap();
    assert_eq!(rows.lines().count(), 41);
}

#[test]
fn an_object_is_the_same_in_any_company_and_differs_with_the_seed() {
    let (_folder, [both, alone, other]) = places(["both", "alone", "other"]);
    run(QUICK, &both);
    run("--object small-cup --count 20 --seed 7", &alone);
    run("--object small-cup --count 20 --seed 8", &other);
    assert_same(&both.join("small-cup"), &alone.join("small-cup"));
    assert_ne!(
        tree(&other.join("small-cup")),
        tree(&alone.join("small-cup"))
    );
}

#[test]
fn a_greater_count_goes_on_in_the_same_order() {
    let (_folder, [few, many]) = places(["few", "many"]);
    run("--object tiny-ball --count 8", &few);
    run("--object tiny-ball --count 20", &many);
    let many = tree(&many.join("tiny-ball"));
    for (name, bytes) in tree(&few.join("tiny-ball")) {
        assert!(many[&name] == bytes, "{name:?}");
    }
}

#[test]
fn shards_merged_are_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    run(QUICK, &whole);
    // More shards than an object has grasps: some parts have nothing of it.
    for shards in [1, 3, 5] {
        let part = |number: usize| folder.path().join(format!("{number}of{shards}"));
        let parts: Vec<_> = (1..=shards).map(part).collect();
        for (index, part) in parts.iter().enumerate() {
            run(&format!("{QUICK} --shard {}/{shards}", index + 1), part);
        }
        let merged = folder.path().join(format!("merged{shards}"));
        let in_any_order: Vec<&Path> = parts.iter().rev().map(|part| part.as_path()).collect();
        let output = merge(&merged, &in_any_order).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        assert_same(&whole, &merged);
        assert!(!tree(&parts[0]).is_empty(), "the parts stay");
    }
}

#[test]
fn runs_killed_at_random_points_go_on() {
    let (_folder, [whole, killed]) = places(["whole", "killed"]);
    let start = Instant::now();
    run(QUICK, &whole);
    let time = start.elapsed();
    let wanted = tree(&whole);

    let seed = rand::random::<u64>();
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for _ in 0..8 {
        let before = inodes(&killed);
        let mut child = program(QUICK, &killed)
            .stderr(Stdio::null())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(time.mul_f64(random.random_range(0.0..0.9)));
        child.kill().unwrap();
        child.wait().unwrap();
        for (name, bytes) in tree_if_there(&killed) {
            let is_final = !name.to_string_lossy().contains("unfinished");
            assert!(!is_final || wanted[&name] == bytes, "{name:?} is not whole");
        }
        let after = inodes(&killed);
        for (name, inode) in before {
            assert_eq!(after.get(&name), Some(&inode), "{name} was written again");
        }
    }
    let before = inodes(&killed);
    run(QUICK, &killed);
    assert_same(&whole, &killed);
    let after = inodes(&killed);
    assert!(before.iter().all(|(name, inode)| after[name] == *inode));
}

#[test]
fn a_run_asked_to_stop_says_how_to_go_on() {
    let (_folder, [whole, stopped]) = places(["whole", "stopped"]);
    let many = "--object tiny-ball --count 120 --jobs 2";
    let child = program(many, &stopped)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    // Only looked for: files in the making come and go.
    let has_mesh = || {
        let entries = fs::read_dir(stopped.join("tiny-ball"))
            .into_iter()
            .flatten();
        let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        paths.any(|path| path.extension().is_some_and(|end| end == "ply"))
    };
    while !has_mesh() {
        assert!(Instant::now() < deadline, "no mesh in time");
        std::thread::sleep(Duration::from_millis(2));
    }
    let process = child.id().to_string();
    let sent = Command::new("kill").args(["-TERM", &process]).status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(
        said.contains("the same command goes on from there"),
        "{said}"
    );
    assert!(!stopped.join("manifest.csv").exists());
    run(many, &stopped);
    run(many, &whole);
    assert_same(&whole, &stopped);
}

#[test]
fn meshes_that_were_removed_are_made_again() {
    let (_folder, [whole, robbed]) = places(["whole", "robbed"]);
    run(QUICK, &whole);
    run(QUICK, &robbed);
    fs::remove_file(robbed.join("tiny-ball/0003.ply")).unwrap();
    fs::write(robbed.join("small-cup/0019.ply"), "").unwrap();
    fs::remove_file(robbed.join("losses.png")).unwrap();
    run(QUICK, &robbed);
    assert_same(&whole, &robbed);
}

fn tree_if_there(folder: &Path) -> std::collections::BTreeMap<std::path::PathBuf, Vec<u8>> {
    if folder.exists() {
        tree(folder)
    } else {
        Default::default()
    }
}

/// Inodes of the meshes: a file that was written again has another.
fn inodes(folder: &Path) -> std::collections::BTreeMap<String, u64> {
    let files = tree_if_there(folder).into_keys();
    let meshes = files.filter(|name| name.extension().is_some_and(|end| end == "ply"));
    let inode = |name: std::path::PathBuf| {
        let metadata = fs::metadata(folder.join(&name)).unwrap();
        (name.to_string_lossy().into_owned(), metadata.ino())
    };
    meshes
        .filter(|name| !name.to_string_lossy().contains("unfinished"))
        .map(inode)
        .collect()
}
