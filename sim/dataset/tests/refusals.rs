//! What is refused, how it is said, and what is left behind: nothing.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use common::{QUICK, assert_same, merge, places, program, refusal, run, shards_and_whole, tree};

#[test]
fn wrong_usage_is_code_2_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let settings = folder.path().join("settings.yaml");
    fs::write(&settings, "intensities_m: [0.004, 0.002]").unwrap();
    let with_settings = format!("--object tiny-ball --settings {}", settings.display());
    let wide = folder.path().join("wide.yaml");
    fs::write(&wide, "dent: {grasp: {graspable_ratio: 2}}").unwrap();
    let with_ratio = format!("--object tiny-ball --settings {}", wide.display());
    for (words, named) in [
        ("", "--scan"),
        (
            "--object blob",
            "unknown object 'blob': expected one of medium-can",
        ),
        ("--object tiny-ball --count 0", "--count"),
        ("--object tiny-ball --count -1", "-1"),
        ("--object tiny-ball --jobs 0", "--jobs"),
        ("--object tiny-ball --shard 5/4", "'5/4' is no shard"),
        ("--object tiny-ball --shard 0/4", "'0/4' is no shard"),
        ("--object tiny-ball --units cm", "cm"),
        (
            "--object tiny-ball --object tiny-ball",
            "two sources are called 'tiny-ball'",
        ),
        ("--object tiny-ball --count 1000000", "ask for --count"),
        ("--scan a:b.ply", "'a:b' cannot name an object"),
        ("--scan run.yaml.ply", "'run.yaml' cannot name an object"),
        (&with_settings, "rising"),
        (&with_ratio, "graspable_ratio is 2"),
    ] {
        let said = refusal(&mut program(words, &out), 2);
        assert!(said.contains(named), "{words}: {said}");
        assert!(!out.exists(), "{words} left something");
    }
    refusal(&mut merge(&out, &[]), 2);
}

#[test]
fn what_cannot_be_read_or_written_is_code_1_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let garbage = folder.path().join("garbage.ply");
    fs::write(&garbage, "ply, but not really").unwrap();
    for file in [folder.path().join("missing.ply"), garbage.clone()] {
        let words = format!("--scan {}", file.display());
        let said = refusal(&mut program(&words, &out), 1);
        assert!(said.contains(file.to_str().unwrap()), "{said}");
        assert!(!out.exists());
    }
    let said = refusal(&mut program("--object tiny-ball --count 1", &garbage), 1);
    assert!(said.contains("garbage.ply"), "{said}");
    let below_file = garbage.join("out");
    let said = refusal(&mut program("--object tiny-ball --count 1", &below_file), 1);
    assert!(said.contains("cannot make"), "{said}");
    assert_eq!(fs::read_to_string(&garbage).unwrap(), "ply, but not really");
}

#[test]
fn another_dataset_in_the_folder_is_refused_by_name() {
    let (folder, [out, copy]) = places(["out", "copy"]);
    run("--object tiny-ball --count 6", &out);
    run("--object tiny-ball --count 6", &copy);
    let settings = folder.path().join("settings.yaml");
    fs::write(&settings, "intensities_m: [0.003]").unwrap();
    let with_settings = format!(
        "--object tiny-ball --count 6 --settings {}",
        settings.display()
    );
    for (words, named) in [
        (
            "--object tiny-ball --count 6 --seed 2",
            "seed: 1 there, 2 here",
        ),
        (
            "--object tiny-ball --count 7",
            "objects[0].meshes: 6 there, 7 here",
        ),
        (
            "--object small-ball --count 6",
            "objects[0].name: tiny-ball there, small-ball here",
        ),
        (
            "--object tiny-ball --count 6 --shard 1/2",
            "shard: none there, 1/2 here",
        ),
        (&with_settings, "settings.intensities_m: [0.004"),
    ] {
        let said = refusal(&mut program(words, &out), 1);
        assert!(said.contains(named), "{words}: {said}");
        assert!(said.contains("use another --out"), "{said}");
        assert_same(&copy, &out);
    }
    let said = refusal(
        &mut program("--object tiny-ball --count 6", folder.path()),
        1,
    );
    assert!(
        said.contains("and no run.yaml, so it is no dataset"),
        "{said}"
    );
    assert_same(&copy, &out);
}

#[test]
fn a_second_run_in_the_same_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let words = "--object tiny-ball --count 120 --jobs 1";
    let mut first = program(words, &out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !out.join("run.yaml").exists() {
        assert!(first.try_wait().unwrap().is_none(), "it ended early");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let said = refusal(&mut program(words, &out), 1);
    assert!(said.contains("another run is at work"), "{said}");
    assert!(first.wait().unwrap().success());
}

#[test]
fn parts_that_do_not_make_a_whole_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [one, two, other, of_three, whole, out] =
        ["one", "two", "other", "of-three", "whole", "out"].map(path);
    let words = "--object tiny-ball --count 24";
    run(&format!("{words} --shard 1/2"), &one);
    run(&format!("{words} --shard 2/2"), &two);
    run(&format!("{words} --seed 2 --shard 2/2"), &other);
    run(&format!("{words} --shard 2/3"), &of_three);
    run(words, &whole);
    let refused = |parts: &[&Path], named: &str| {
        let said = refusal(&mut merge(&out, parts), 1);
        assert!(said.contains(named), "{parts:?}: {said}");
        assert!(!out.exists(), "{parts:?} left something");
    };
    refused(&[&one], "missing: shard 2/2");
    refused(&[&one, &one, &two], "are both shard 1/2");
    refused(
        &[&one, &other],
        "parts of different datasets: seed: 1 there, 2 here",
    );
    refused(&[&one, &of_three], "shard: 1/2 there, 2/3 here");
    refused(&[&one, &whole], "is no part: it was made without --shard");
    refused(&[&one, &path("nothing")], "run.yaml");

    let mesh = tree(&two)
        .into_keys()
        .find(|name| name.starts_with("tiny-ball"));
    let mesh = mesh.unwrap();
    fs::rename(two.join(&mesh), path("aside")).unwrap();
    refused(&[&one, &two], mesh.to_str().unwrap());
    fs::rename(path("aside"), two.join(&mesh)).unwrap();
    fs::rename(two.join("manifest.csv"), path("aside")).unwrap();
    refused(&[&one, &two], "(shard 2/2) is not finished");
    fs::rename(path("aside"), two.join("manifest.csv")).unwrap();

    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    assert_same(&whole, &out);
    let said = refusal(&mut merge(&out, &[&one, &two]), 1);
    assert!(said.contains("holds a dataset already"), "{said}");
    assert_same(&whole, &out);
}

#[test]
fn a_merge_that_was_interrupted_goes_on() {
    let (_folder, [one, two, out, whole]) = shards_and_whole("out");
    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    // As a kill leaves it: the record, and some of the rest.
    fs::remove_file(out.join("manifest.csv")).unwrap();
    fs::remove_file(out.join("tiny-ball/0007.ply")).unwrap();
    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    assert_same(&whole, &out);
}

/// A file system of this size, unmounted at the end. `None`, with a line why, where none can be mounted.
struct SmallDisk<'a>(&'a Path);

impl<'a> SmallDisk<'a> {
    fn mount(folder: &'a Path, options: &str) -> Option<Self> {
        fs::create_dir_all(folder).unwrap();
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", options, "tmpfs"])
            .arg(folder);
        match mount.output() {
            Ok(output) if output.status.success() => Some(Self(folder)),
            refused => {
                let why = refused.map_or_else(
                    |error| error.to_string(),
                    |output| common::stderr(&output).trim().to_owned(),
                );
                // Not println!, which is shown of failures alone.
                let line =
                    format!("\nNot tested on a small disk, since none can be mounted: {why}\n");
                std::io::stderr().write_all(line.as_bytes()).unwrap();
                None
            }
        }
    }
}

impl Drop for SmallDisk<'_> {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg(self.0).status();
        assert!(unmounted.is_ok_and(|status| status.success()));
    }
}

#[test]
fn a_full_disk_leaves_only_whole_meshes_and_the_run_goes_on_later() {
    let (_folder, [disk, whole]) = places(["disk", "whole"]);
    run(QUICK, &whole);
    let wanted = tree(&whole);
    let bytes: usize = wanted.values().map(Vec::len).sum();
    for share in [0.0, 0.1, 0.5, 0.98] {
        let size = (share * bytes as f64) as usize + 16_384;
        let Some(_mounted) = SmallDisk::mount(&disk, &format!("size={size}")) else {
            return;
        };
        let out = disk.join("out");
        let said = refusal(&mut program(&format!("{QUICK} --jobs 2"), &out), 1);
        assert!(said.contains("No space left"), "{said}");
        for (name, bytes) in tree(&out) {
            let is_journal = name == Path::new("manifest.unfinished.csv");
            assert!(
                is_journal || wanted[&name] == bytes,
                "{name:?} is not whole"
            );
        }
        let larger = Command::new("mount")
            .args(["-o", "remount,size=1g"])
            .arg(&disk)
            .status();
        assert!(larger.unwrap().success());
        run(QUICK, &out);
        assert_same(&whole, &out);
    }
}

#[test]
fn parts_are_copied_to_another_disk() {
    let (_folder, [one, two, disk, whole]) = shards_and_whole("disk");
    let Some(_mounted) = SmallDisk::mount(&disk, "size=1g") else {
        return;
    };
    let out = disk.join("out");
    assert!(merge(&out, &[&one, &two]).status().unwrap().success());
    assert_same(&whole, &out);
}
