//! What `evaluate` measures, and what it says of data that a model may know.
#![allow(clippy::unwrap_used)]

use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::AtomicBool;

use classifier::{Model, Provider};
use sim_dataset::generate::generate;
use sim_dataset::object::Source;
use sim_objects::ObjectClass;
use sim_scan::ScanParameters;
use training::data::trained_on::Unseen;
use training::evaluation::{Evaluation, Settings, evaluate};
use training::network::backend::Backend;
use training::run::{Order, run};

fn shipped() -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/model.onnx");
    Model::load(&path, Provider::Cpu, "CPU").unwrap()
}

fn measured(model: &mut Model, dataset: Option<&Path>) -> Evaluation {
    let settings = Settings {
        specimens: NonZeroUsize::MIN,
        dataset: dataset.map(Path::to_path_buf),
        scans: ScanParameters {
            view_count: 2,
            ..ScanParameters::default()
        },
        seed: 9001,
    };
    evaluate(model, &settings, || ()).unwrap()
}

fn make(out: &Path, seed: u64) {
    let objects = [ObjectClass::MediumBall, ObjectClass::LargeCup];
    let order = sim_dataset::order::Order {
        sources: objects.map(Source::Parametric).to_vec(),
        out: out.to_path_buf(),
        count: NonZeroUsize::new(36),
        seed,
        jobs: NonZeroUsize::MIN,
        shard: None,
        settings: Default::default(),
    };
    generate(&order, &AtomicBool::new(false), &|_| ()).unwrap();
}

#[test]
fn the_shipped_model_is_measured_on_whole_surfaces_and_on_views() {
    let mut model = shipped();
    let found = measured(&mut model, None);
    let whole = &found.tests[0];
    assert!(whole.data.ends_with("whole surface"), "{}", whole.data);
    assert_eq!(whole.test.clouds, 8);
    assert!(whole.test.accuracy >= 7.0 / 8.0, "{}", found.to_text());
    assert_eq!(whole.test.confusion.labels, model.metadata().labels);
    let views = found.tests.iter().filter(|test| test.data.contains("view"));
    assert!(views.count() >= 2, "{}", found.to_text());
    // Eight strangers and an empty hand, each seen from all sides and by its views.
    assert!(found.known.stranger_clouds >= 17 && found.known.auroc > 0.5);
    assert!(found.to_text().contains("none of it was trained on"));
    // Without a dataset, and no number that is none.
    let numbers = serde_json::to_string(&found).unwrap();
    assert_eq!(numbers.matches("null").count(), 1, "{numbers}");
    assert!(numbers.contains(r#""of_dataset":null"#), "{numbers}");
}

#[test]
fn meshes_that_a_model_was_trained_on_are_left_out_or_named() {
    let folder = tempfile::tempdir().unwrap();
    let [known, other] = ["known", "other"].map(|name| folder.path().join(name));
    make(&known, 5);
    make(&other, 6);
    let mut settings = training::settings::Settings {
        specimens_per_class: 2,
        strangers: 1,
        validation_specimens_per_class: 1,
        point_count: 32,
        only_datasets: true,
        ..Default::default()
    };
    settings.training.epochs = 1;
    settings.scans.view_count = 1;
    let order = Order {
        settings,
        datasets: vec![known.clone()],
        output: folder.path().join("output"),
        model: folder.path().join("model.onnx"),
        backend: Backend::Cpu,
        fresh: false,
    };
    run(&order, |_| ()).unwrap();
    let mut model = Model::load(&order.model, Provider::Cpu, "CPU").unwrap();

    let found = measured(&mut model, Some(&known));
    assert_eq!(found.of_dataset, Some(Unseen::HeldOut));
    assert!(found.to_text().contains("held out in training"));
    let found = measured(&mut model, Some(&other));
    assert_eq!(found.of_dataset, Some(Unseen::All));
    assert!(found.to_text().contains("none of it was trained on"));

    // The shipped model's file is of before such entries were written.
    let mut shipped = shipped();
    if shipped.metadata().trained_on.is_none() {
        let found = measured(&mut shipped, Some(&known));
        assert_eq!(found.of_dataset, Some(Unseen::Unknown));
        let text = found.to_text();
        assert!(text.contains("perhaps trained on") && text.contains("does not say whether"));
        assert!(!text.contains("none of it was trained on"), "{text}");
    }
}

#[test]
fn no_specimens_are_no_measurement() {
    let output = Command::new(env!("CARGO_BIN_EXE_evaluate"))
        .args(["--specimens", "0"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("--specimens"), "{said}");
}
