//! Training on datasets of meshes: good and bad ones, and interrupted.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{BufRead, BufReader};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, OnceLock};

use classifier::{Model, Provider};
use mesh::file::MILLIMETRE;
use nalgebra::{Point3, Vector3};
use program::describe;
use sim_dataset::generate::generate;
use sim_dataset::object::Source;
use sim_objects::{ObjectClass, Stranger};
use training::data::{LabelledClouds, Split};
use training::network::Head;
use training::network::backend::Backend;
use training::progress::Stage;
use training::run::{Order, run};
use training::settings::Settings;

fn make(out: &Path, objects: &[ObjectClass], count: usize) {
    let sources = objects.iter().copied().map(Source::Parametric).collect();
    make_of(out, sources, count);
}

fn make_of(out: &Path, sources: Vec<Source>, count: usize) {
    let order = sim_dataset::order::Order {
        sources,
        out: out.to_path_buf(),
        count: NonZeroUsize::new(count),
        seed: 5,
        jobs: NonZeroUsize::MIN,
        shard: None,
        settings: Default::default(),
    };
    generate(&order, &AtomicBool::new(false), &|_| ()).unwrap();
}

/// A dataset of two unlike objects, which every test but those that spoil it shares.
fn dataset() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let objects = [ObjectClass::MediumBall, ObjectClass::LargeCup];
        make(folder.path(), &objects, 36);
        folder
    });
    folder.path()
}

fn order(folder: &Path, datasets: &[&Path]) -> Order {
    let mut settings = Settings::of_paper();
    settings.paper.features = 16;
    settings.point_count = 24;
    settings.training.epochs = 12;
    settings.training.batch_size = 8;
    settings.meshes.surface_points = 256;
    settings.meshes.kept_points = 32;
    Order {
        settings,
        datasets: datasets.iter().map(PathBuf::from).collect(),
        output: folder.join("output"),
        model: folder.join("model.onnx"),
        backend: Backend::Cpu,
        fresh: false,
    }
}

#[test]
fn the_papers_network_learns_to_tell_two_objects_apart_with_and_without_normals_and_flattened() {
    for (normals, head) in [
        (false, Head::Pool),
        (true, Head::Pool),
        (false, Head::Flatten),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut order = order(folder.path(), &[dataset()]);
        order.settings.paper.normals = normals;
        order.settings.paper.head = head;
        let results = run(&order, |_| ()).unwrap();
        let test = results.test.unwrap();
        assert_eq!(test.confusion.labels, ["large-cup", "medium-ball"]);
        assert!(test.accuracy > 0.9, "{}", test.confusion.table());
        let mut model = Model::load(&order.model, Provider::Cpu, "CPU").unwrap();
        assert_eq!(model.metadata().normals, normals);
        let ball: Vec<Point3<f32>> = (0..500)
            .map(|index| {
                let z = 1.0 - (2.0 * index as f32 + 1.0) / 500.0;
                let (sin, cos) = (2.399_963 * index as f32).sin_cos();
                let across = (1.0 - z * z).sqrt();
                Point3::new(across * cos, across * sin, z) * 0.047
            })
            .collect();
        let answer = model.classify(&ball, &Vector3::z()).unwrap();
        assert_eq!(answer.label, "medium-ball");
    }
}

#[test]
fn objects_are_learned_without_the_eight_and_apart_from_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut order = order(folder.path(), &[dataset()]);
    order.settings = Settings {
        specimens_per_class: 2,
        strangers: 1,
        validation_specimens_per_class: 1,
        point_count: 32,
        only_datasets: true,
        ..Settings::default()
    };
    order.settings.training.epochs = 1;
    order.settings.scans.view_count = 1;
    let alone = run(&order, |_| ()).unwrap();
    assert_eq!(alone.confusion.labels, ["large-cup", "medium-ball"]);
    // The clouds of one are not those of the other, whose settings are the same but for this.
    order.settings.only_datasets = false;
    assert_eq!(run(&order, |_| ()).unwrap().confusion.labels.len(), 8);
}

#[test]
fn an_own_object_is_learned_beside_the_eight() {
    let folder = tempfile::tempdir().unwrap();
    let scan = folder.path().join("bottle.ply");
    mesh::file::write_ply(&scan, &Stranger::Bottle.mesh().subdivided()).unwrap();
    let bottle = Source::Scan {
        file: scan,
        metres_per_unit: MILLIMETRE,
    };
    let dataset = folder.path().join("dataset");
    make_of(&dataset, vec![bottle], 18);
    let mut settings = Settings {
        specimens_per_class: 2,
        strangers: 0,
        validation_specimens_per_class: 1,
        point_count: 32,
        ..Settings::default()
    };
    settings.training.epochs = 1;
    settings.scans.view_count = 1;
    let order = Order {
        settings,
        ..order(folder.path(), &[&dataset])
    };
    let refusal = |datasets: Vec<PathBuf>, only_datasets| {
        let mut order = Order {
            datasets,
            ..order.clone()
        };
        order.settings.only_datasets = only_datasets;
        describe(run(&order, |_| ()).unwrap_err().as_ref())
    };
    let message = refusal(vec![dataset.clone()], true);
    assert!(message.contains("holds bottle alone"), "{message}");
    let message = refusal(Vec::new(), true);
    assert!(message.contains("give --dataset"), "{message}");
    let message = refusal(vec![dataset.clone(), dataset.clone()], false);
    assert!(message.contains("both hold bottle"), "{message}");
    let results = run(&order, |_| ()).unwrap();
    let model = Model::load(&order.model, Provider::Cpu, "CPU").unwrap();
    let labels = &model.metadata().labels;
    assert_eq!((labels.len(), labels[8].as_str()), (9, "bottle"));
    assert_eq!(results.confusion.counts.len(), 9);
    assert!(results.confusion.counts[8].iter().sum::<u32>() > 0);
}

#[test]
fn grasps_stay_on_one_side_of_the_split_and_shares_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let order = order(folder.path(), &[dataset()]);
    run(&order, |_| ()).unwrap();
    let entries = fs::read_dir(&order.output).unwrap();
    let mut folders = entries.map(|entry| entry.unwrap().path());
    let clouds = folders
        .find(|path| path.join("clouds.npz").exists())
        .unwrap();
    let (clouds, _) = LabelledClouds::read(&clouds.join("clouds.npz")).unwrap();
    assert_eq!((clouds.len(), clouds.point_count), (72, 32));
    // Six meshes of each grasp follow each other.
    for grasp in clouds.split.chunks(6) {
        assert!(grasp.iter().all(|split| *split == grasp[0]), "{grasp:?}");
    }
    for (split, count) in [
        (Split::Test, 24),
        (Split::Validation, 12),
        (Split::Train, 36),
    ] {
        let part = clouds.part(split, 24);
        assert_eq!(part.labels.len(), count);
        assert_eq!(part.values.len(), count * 24 * 3);
        let balls = part.labels.iter().filter(|label| **label == 1).count();
        assert_eq!(balls, count / 2);
    }
    let radius = |point: &[f32]| point.iter().map(|value| value * value).sum::<f32>().sqrt();
    let largest = clouds.values.chunks(3).map(radius).fold(0.0, f32::max);
    assert!((0.08..0.11).contains(&largest), "{largest} m");
}

#[test]
fn the_same_dataset_is_sampled_once_for_all_numbers_of_points() {
    let folder = tempfile::tempdir().unwrap();
    let sampled = |points| {
        let mut order = order(folder.path(), &[dataset()]);
        order.settings.point_count = points;
        let sampled = Mutex::new(0);
        run(&order, |stage| {
            *sampled.lock().unwrap() += usize::from(matches!(stage, Stage::Scanned));
        })
        .unwrap();
        sampled.into_inner().unwrap()
    };
    assert_eq!([sampled(24), sampled(32), sampled(8)], [72, 0, 0]);
}

/// Spoils a copy of the dataset, trains on it, and returns what was refused. Nothing may be left of the attempt.
fn refusal(spoil: impl FnOnce(&Path)) -> String {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("dataset");
    make(&copy, &[ObjectClass::MediumBall, ObjectClass::LargeCup], 18);
    spoil(&copy);
    let order = order(folder.path(), &[&copy]);
    let error = run(&order, |_| ()).unwrap_err();
    assert!(!order.output.exists() && !order.model.exists());
    describe(error.as_ref())
}

#[test]
fn a_folder_that_is_no_whole_dataset_is_refused_with_the_remedy() {
    let message = refusal(|folder| fs::remove_dir_all(folder).unwrap());
    assert!(message.contains("no dataset folder") && message.contains("generate_dataset --out"));
    let message = refusal(|folder| fs::remove_file(folder.join("manifest.csv")).unwrap());
    assert!(
        message.contains("has no manifest.csv; it is no dataset"),
        "{message}"
    );
    let message = refusal(|folder| {
        let journal = folder.join("manifest.unfinished.csv");
        fs::rename(folder.join("manifest.csv"), journal).unwrap();
    });
    assert!(
        message.contains("give generate_dataset the same command again"),
        "{message}"
    );
    let message = refusal(|folder| fs::write(folder.join("manifest.csv"), "a,b\n1,2\n").unwrap());
    assert!(
        message.contains("manifest.csv is damaged; make the dataset again"),
        "{message}"
    );
}

#[test]
fn a_missing_truncated_or_foreign_mesh_is_named() {
    let mesh = |folder: &Path| folder.join("large-cup/0003.ply");
    let message = refusal(|folder| fs::remove_file(mesh(folder)).unwrap());
    assert!(
        message.contains("large-cup/0003.ply is missing"),
        "{message}"
    );
    let message = refusal(|folder| {
        let bytes = fs::read(mesh(folder)).unwrap();
        fs::write(mesh(folder), &bytes[..bytes.len() / 2]).unwrap();
    });
    assert!(
        message.contains("large-cup/0003.ply: ends too early"),
        "{message}"
    );
    let message = refusal(|folder| fs::write(mesh(folder), "not a mesh").unwrap());
    assert!(
        message.contains("large-cup/0003.ply: is no valid PLY"),
        "{message}"
    );
    let message = refusal(|folder| {
        fs::copy(folder.join("medium-ball/0003.ply"), mesh(folder)).unwrap();
    });
    assert!(message.contains("0003.ply is not the mesh that manifest.csv was written for"));
    let message = refusal(|folder| fs::write(folder.join("large-cup/mine.ply"), "").unwrap());
    assert!(
        message.contains("large-cup/mine.ply is not in manifest.csv"),
        "{message}"
    );
}

#[test]
fn classes_that_cannot_be_split_or_told_apart_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |objects: &[ObjectClass], count| {
        let out = tempfile::tempdir_in(folder.path()).unwrap();
        make(out.path(), objects, count);
        describe(
            run(&order(folder.path(), &[out.path()]), |_| ())
                .unwrap_err()
                .as_ref(),
        )
    };
    let message = refusal(&[ObjectClass::TinyBall, ObjectClass::LargeCup], 12);
    assert!(
        message.contains("large-cup has too few meshes: 12 of 2 unlike grasps"),
        "{message}"
    );
    let message = refusal(&[ObjectClass::TinyBall], 18);
    assert!(message.contains("holds tiny-ball alone"), "{message}");
}

#[test]
fn a_loss_that_is_no_number_is_named_and_leaves_no_model() {
    let folder = tempfile::tempdir().unwrap();
    let mut order = order(folder.path(), &[dataset()]);
    order.settings.training.augmentation.shift_m = f64::MAX;
    let message = describe(run(&order, |_| ()).unwrap_err().as_ref());
    assert!(
        message.contains("not a number any more in epoch 1; lower"),
        "{message}"
    );
    assert!(!order.model.exists());
}

fn train(output: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_train"));
    let words = "--network paper --features 16 --points 24 --epochs 40 --dataset";
    command.args(words.split(' ')).arg(dataset());
    command.arg("--output").arg(output).stdin(Stdio::null());
    command
}

#[test]
fn a_killed_training_goes_on_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (through, killed) = (folder.path().join("a"), folder.path().join("b"));
    assert!(train(&through).output().unwrap().status.success());

    let mut child = train(&killed).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let reached = lines.any(|line| line.unwrap().starts_with("epoch   5:"));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(reached && !killed.join("model.onnx").exists());

    let output = train(&killed).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("going on after epoch"), "{said}");
    let model = |output: &Path| fs::read(output.join("model.onnx")).unwrap();
    assert!(model(&through) == model(&killed), "the models differ");
    let unfinished = |path: &PathBuf| path.to_string_lossy().contains("checkpoint");
    let run_folders = fs::read_dir(&killed)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let run_folders = run_folders.filter(|path| path.is_dir());
    let files = run_folders.flat_map(|folder| fs::read_dir(folder).unwrap());
    assert!(
        !files
            .map(|entry| entry.unwrap().path())
            .any(|path| unfinished(&path))
    );
}
