//! Whole training runs, small ones.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;
use std::sync::Mutex;

use adaptation::{Kept, features_path};
use classifier::{Model, Provider, SelfTest};
use sim_dataset::digest::hex_digest;
use training::network::backend::Backend;
use training::network::start::Start;
use training::progress::Stage;
use training::run::{Order, Results, run};
use training::settings::Settings;

fn small() -> Settings {
    let mut settings = Settings {
        specimens_per_class: 2,
        strangers: 5,
        validation_specimens_per_class: 1,
        point_count: 32,
        ..Settings::default()
    };
    settings.training.epochs = 2;
    settings.scans.view_count = 2;
    settings
}

fn order(folder: &Path, settings: &Settings) -> Order {
    Order {
        settings: settings.clone(),
        datasets: Vec::new(),
        output: folder.join("output"),
        model: folder.join("model.onnx"),
        backend: Backend::Cpu,
        fresh: false,
    }
}

fn run_in(folder: &Path, settings: &Settings) -> anyhow::Result<Results> {
    run(&order(folder, settings), |_| ())
}

#[test]
fn a_run_writes_a_model_that_loads_and_a_record() {
    let folder = tempfile::tempdir().unwrap();
    let results = run_in(folder.path(), &small()).unwrap();
    let model = Model::load(&folder.path().join("model.onnx"), Provider::Cpu, "CPU").unwrap();
    assert_eq!(model.metadata().run_id, results.run_id);
    assert_eq!(model.metadata().point_count, 32);
    assert_eq!(model.metadata().known_threshold, results.known_threshold);
    assert_eq!(results.history.len(), 2);
    let record = folder
        .path()
        .join("output")
        .join(&results.run_id)
        .join("run.yaml");
    let record: serde_yaml::Value =
        serde_yaml::from_slice(&std::fs::read(record).unwrap()).unwrap();
    assert_eq!(record["settings"]["specimens_per_class"], 2);
    assert_eq!(record["commit"], sim_dataset::record::COMMIT);
    assert!(record["code"].is_string());
    assert!(record["results"]["validation_accuracy"].is_f64());
}

#[test]
fn a_run_leaves_what_teach_needs_beside_the_model() {
    let folder = tempfile::tempdir().unwrap();
    run_in(folder.path(), &small()).unwrap();
    let path = folder.path().join("model.onnx");
    let kept = Kept::decode(&std::fs::read(features_path(&path)).unwrap()).unwrap();
    assert_eq!(kept.model, hex_digest(&std::fs::read(&path).unwrap()));
    let model = Model::load(&path, Provider::Cpu, "CPU").unwrap();
    let labels = kept.blocks.iter().map_while(|block| block.label.clone());
    assert!(labels.eq(model.metadata().labels.iter().cloned()));
    let strangers = kept.strangers().unwrap();
    for block in &kept.blocks {
        assert!(!block.fit.is_empty() && !block.check.is_empty());
        assert!(block.fit.len() <= strangers.fit.len());
    }
    let run_id = &model.metadata().run_id;
    assert!(SelfTest::beside(&path, run_id).unwrap().is_some());
}

#[test]
fn training_goes_on_from_the_weights_of_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let first = run_in(folder.path(), &small()).unwrap();
    let path = folder.path().join("model.onnx");
    let before = std::fs::read(&path).unwrap();
    let settings = |epochs, rate| {
        let mut settings = small();
        settings.start = Some(Start::of(&path).unwrap());
        settings.training.epochs = epochs;
        settings.training.learning_rate = rate;
        settings
    };
    // Without a step that is felt, the answers stay what they were.
    let same = run(&order(folder.path(), &settings(1, 0.0)), |_| ()).unwrap();
    assert_eq!(same.confusion, first.confusion);
    assert_ne!(same.run_id, first.run_id);
    std::fs::write(&path, &before).unwrap();
    let stale = settings(1, 1e-3);
    std::fs::write(&path, [&before[..], b" "].concat()).unwrap();
    let refused = run_in(folder.path(), &stale).unwrap_err().to_string();
    assert!(refused.contains("has changed meanwhile"), "{refused}");
}

#[test]
fn the_same_settings_give_the_same_file_and_another_seed_does_not() {
    let bytes = |seed| {
        let folder = tempfile::tempdir().unwrap();
        run_in(folder.path(), &Settings { seed, ..small() }).unwrap();
        std::fs::read(folder.path().join("model.onnx")).unwrap()
    };
    let first = bytes(1);
    assert!(first == bytes(1), "two runs with the same settings differ");
    assert!(first != bytes(2), "two seeds give the same model");
}

#[test]
fn scans_are_made_once_for_the_same_settings() {
    let folder = tempfile::tempdir().unwrap();
    let scanned = |settings: &Settings, fresh| {
        let scanned = Mutex::new(0);
        let show = |stage| {
            if matches!(stage, Stage::Scanned) {
                *scanned.lock().unwrap() += 1;
            }
        };
        let order = Order {
            fresh,
            ..order(folder.path(), settings)
        };
        run(&order, show).unwrap();
        scanned.into_inner().unwrap()
    };
    // Two and one of each of the eight, five and one solids, an empty hand; and to be kept for teach as many of the eight,
    // six and three solids, an empty hand.
    assert_eq!(scanned(&small(), false), 31 + 34);
    let mut longer = small();
    longer.training.epochs = 3;
    assert_eq!(scanned(&longer, false), 0);
    assert_eq!(scanned(&longer, true), 31 + 34);
}

#[test]
fn a_failed_run_names_the_fault_and_leaves_the_model_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.onnx");
    std::fs::write(&model, "before").unwrap();
    let refusal = |settings: &Settings| {
        let message = program::describe(run_in(folder.path(), settings).unwrap_err().as_ref());
        assert_eq!(std::fs::read_to_string(&model).unwrap(), "before");
        message
    };
    let mut large = small();
    large.architecture.features = 500;
    let message = refusal(&large);
    assert!(
        message.contains("at most 100000") && message.contains("fewer features"),
        "{message}"
    );
    let mut steep = small();
    steep.training.learning_rate = 1.0;
    steep.training.augmentation.shift_m = f64::MAX;
    let message = refusal(&steep);
    assert!(message.contains("loss is not a number"), "{message}");
}

#[test]
fn two_runs_with_the_same_settings_do_not_write_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let results = run_in(folder.path(), &small()).unwrap();
    let other = std::fs::File::open(
        folder
            .path()
            .join("output")
            .join(&results.run_id)
            .join("lock"),
    );
    let other = other.unwrap();
    other.lock().unwrap();
    let refused = run_in(folder.path(), &small()).unwrap_err().to_string();
    assert!(refused.contains("another training") && refused.contains(&results.run_id));
    drop(other);
    run_in(folder.path(), &small()).unwrap();
}

#[test]
fn a_trial_does_not_replace_the_shipped_model() {
    let folder = tempfile::tempdir().unwrap();
    let words = "--specimens 1 --strangers 0 --points 32 --epochs 1 --output out";
    let output = Command::new(env!("CARGO_BIN_EXE_train"))
        .args(words.split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(folder.path().join("out/model.onnx").is_file());
    assert!(!folder.path().join("config").exists());
}
