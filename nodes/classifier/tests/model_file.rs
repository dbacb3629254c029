//! Models that load, and files that must be refused by name.
#![allow(clippy::unwrap_used)]

use std::error::Error;
use std::path::PathBuf;

use classifier::{
    CERTAIN_PROBABILITY, Centring, ClassifyError, Features, KnownBy, LoadError, Model,
    ModelMetadata, Output, Provider, SelfTest, TestCloud, preprocess, preprocess_parts,
    self_test_path,
};
use nalgebra::{Point3, Vector3};
use onnx_file::{Attribute, Dimension, ModelBuilder};
use tempfile::TempDir;

const POINT_COUNT: usize = 4;
const BATCH: Dimension = Dimension::Free("batch");

fn metadata() -> ModelMetadata {
    ModelMetadata {
        labels: vec!["tall".to_owned(), "wide".to_owned()],
        point_count: POINT_COUNT,
        metres_per_unit: 0.1,
        centring: Centring::Box,
        normals: false,
        network_version: "test".to_owned(),
        run_id: "run 1".to_owned(),
        known_threshold: 0.8,
        known_by: KnownBy::Network,
        trained_on: None,
    }
}

/// Which parts of the model file differ from a good one.
struct Fault {
    input: &'static str,
    input_shape: [Dimension<'static>; 3],
    output: &'static str,
    output_size: usize,
    entries: Vec<(&'static str, String)>,
}

impl Default for Fault {
    fn default() -> Self {
        Self {
            input: "points",
            input_shape: [BATCH, Dimension::Fixed(3), Dimension::Fixed(POINT_COUNT)],
            output: "log_probabilities",
            output_size: 2,
            entries: metadata().to_entries(),
        }
    }
}

/// A network that compares the largest z with the largest x.
fn model_bytes(fault: &Fault) -> Vec<u8> {
    let mut model = ModelBuilder::new("tall or wide");
    model.input(fault.input, &fault.input_shape);
    let axes = [
        ("axes", Attribute::Ints(&[2])),
        ("keepdims", Attribute::Int(0)),
    ];
    model.node("ReduceMax", &[fault.input], "extent", &axes);
    let mut weights = vec![0.0; 3 * fault.output_size];
    weights[1] = 10.0;
    weights[2 * fault.output_size] = 10.0;
    model.constant_f32("weights", &[3, fault.output_size], &weights);
    model.node("MatMul", &["extent", "weights"], "logits", &[]);
    model.node(
        "LogSoftmax",
        &["logits"],
        fault.output,
        &[("axis", Attribute::Int(1))],
    );
    model.output(fault.output, &[BATCH, Dimension::Fixed(fault.output_size)]);
    for (key, value) in &fault.entries {
        model.metadata(key, value);
    }
    model.encode()
}

fn write(bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.onnx");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn load_with(fault: &Fault) -> Result<Model, LoadError> {
    let (_folder, path) = write(&model_bytes(fault));
    Model::load(&path, Provider::Cpu, "CPU")
}

fn refusal(fault: &Fault) -> String {
    described(&load_with(fault).unwrap_err())
}

/// An error and its causes, as the programs print it.
fn described(error: &(dyn Error + 'static)) -> String {
    let causes = std::iter::successors(Some(error), |&error| error.source());
    causes
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(": ")
}

/// Five points spread along `direction`, 20 cm from end to end.
fn stick(direction: Vector3<f32>) -> Vec<Point3<f32>> {
    (0..5)
        .map(|i| Point3::from(direction * (0.05 * i as f32)) + Vector3::new(1.0, 2.0, 3.0))
        .collect()
}

#[test]
fn a_good_model_names_what_it_sees() {
    let mut model = load_with(&Fault::default()).unwrap();
    assert_eq!(model.metadata(), &metadata());
    assert_eq!((model.provider(), model.fallback_reason()), ("cpu", None));
    let answer = model.classify(&stick(Vector3::z()), &Vector3::z()).unwrap();
    assert_eq!(answer.label, "tall");
    assert!(answer.known && answer.probability > 0.99, "{answer:?}");
    assert!((answer.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let answer = model.classify(&stick(Vector3::x()), &Vector3::z()).unwrap();
    assert_eq!(answer.label, "wide");
}

#[test]
fn an_even_answer_is_unknown() {
    let mut model = load_with(&Fault::default()).unwrap();
    let diagonal = Vector3::new(0.7, 0.0, 0.7);
    let answer = model.classify(&stick(diagonal), &Vector3::z()).unwrap();
    assert!(!answer.known, "{answer:?}");
}

#[test]
fn an_answer_that_may_be_another_object_is_unknown() {
    let any_score = ModelMetadata {
        known_threshold: -10.0,
        ..metadata()
    };
    let mut model = load_with(&Fault {
        entries: any_score.to_entries(),
        ..Fault::default()
    })
    .unwrap();
    let answer_to = |model: &mut Model, x: f32| {
        let stick = stick(Vector3::new(x, 0.0, 0.7));
        model.classify(&stick, &Vector3::z()).unwrap()
    };
    let even = answer_to(&mut model, 0.65);
    assert!(
        !even.known && even.probability < CERTAIN_PROBABILITY,
        "{even:?}"
    );
    let doubt = even.doubt().unwrap();
    assert!(doubt.starts_with("it may also be wide"), "{doubt}");
    assert!(doubt.contains("more views"), "{doubt}");
    let certain = answer_to(&mut model, 0.1);
    assert!(certain.known && certain.doubt().is_none(), "{certain:?}");
}

/// The network's input of a stick.
fn input(direction: Vector3<f32>) -> Vec<f32> {
    preprocess(&stick(direction), &Vector3::z(), &metadata()).unwrap()
}

#[test]
fn a_self_test_has_the_clouds_that_its_model_names_rightly() {
    let (_folder, path) = write(&model_bytes(&Fault::default()));
    let mut model = Model::load(&path, Provider::Cpu, "CPU").unwrap();
    assert_eq!(SelfTest::beside(&path, "run 1").unwrap(), None);
    let upright = TestCloud::of("tall", &input(Vector3::z()));
    let lying = TestCloud::of("tall", &input(Vector3::x()));
    let clouds = [lying.clone(), upright.clone()];
    let test = SelfTest::of(&mut model, &clouds).unwrap();
    assert_eq!(
        (test.model_id.as_str(), &test.clouds),
        ("run 1", &vec![upright])
    );
    std::fs::write(self_test_path(&path), test.encode().unwrap()).unwrap();
    let read = SelfTest::beside(&path, "run 1").unwrap();
    assert_eq!(read, Some(test.clone()));
    test.try_on(&mut model).unwrap();
    assert_eq!(SelfTest::beside(&path, "run 2").unwrap(), None);

    let failed = SelfTest {
        clouds: clouds.to_vec(),
        ..test
    };
    let said = described(&failed.try_on(&mut model).unwrap_err());
    assert_eq!(said, "the model takes cloud 1 of 2, a tall, for wide");
    let short = SelfTest {
        clouds: vec![TestCloud::of("tall", &[0.5; 7])],
        ..failed
    };
    let said = described(&short.try_on(&mut model).unwrap_err());
    assert!(said.contains("7 numbers"), "{said}");
    std::fs::write(self_test_path(&path), "{").unwrap();
    let said = described(&SelfTest::beside(&path, "run 1").unwrap_err());
    assert!(
        said.contains("selftest.json") && said.contains("teach --prepare"),
        "{said}"
    );
}

#[test]
fn a_model_that_needs_its_features_is_refused_without_them() {
    let taught = ModelMetadata {
        known_by: KnownBy::Features,
        ..metadata()
    };
    let fault = Fault {
        entries: taught.to_entries(),
        ..Fault::default()
    };
    let (_folder, path) = write(&model_bytes(&fault));
    let refusal = || described(&Model::load(&path, Provider::Cpu, "CPU").unwrap_err());
    let said = refusal();
    assert!(
        said.contains("model.features") && said.contains("keep both files together"),
        "{said}"
    );
    std::fs::write(path.with_extension("features"), "nothing").unwrap();
    assert!(refusal().contains("no file of features"));
    // Who makes the features needs the network first.
    Model::load_with(&path, Features::Unused, Provider::Cpu, "CPU").unwrap();
}

#[test]
fn the_up_direction_turns_the_cloud() {
    let mut model = load_with(&Fault::default()).unwrap();
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        for up in [axis, -axis, -3.0 * axis] {
            let answer = model.classify(&stick(up.normalize().cast()), &up).unwrap();
            assert_eq!(answer.label, "tall", "up {up}");
        }
    }
    let refused = model.classify(&stick(Vector3::x()), &Vector3::zeros());
    assert!(refused.unwrap_err().to_string().contains("no length"));
}

#[test]
fn preprocessing_centres_and_scales() {
    let points = [
        [0.0, 0.0, 0.0],
        [0.1, 0.0, 0.0],
        [0.2, 0.0, 0.0],
        [0.2, 0.4, 0.8],
    ];
    let points = points.map(Point3::from);
    let mut model = metadata();
    let columns = |input: Vec<f32>| {
        let mut x = input[..POINT_COUNT].to_vec();
        x.sort_by(f32::total_cmp);
        x
    };
    let box_x = columns(preprocess(&points, &Vector3::z(), &model).unwrap());
    model.centring = Centring::Centroid;
    let centroid_x = columns(preprocess(&points, &Vector3::z(), &model).unwrap());
    for (found, expected) in [
        (box_x, [-1.0, 0.0, 1.0, 1.0]),
        (centroid_x, [-1.25, -0.25, 0.75, 0.75]),
    ] {
        let close = found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(close, "{found:?} is not {expected:?}");
    }
}

#[test]
fn too_few_points_and_points_that_are_not_finite_are_refused() {
    let mut model = load_with(&Fault::default()).unwrap();
    let mut points = stick(Vector3::z());
    let refused = model.classify(&points[..3], &Vector3::z()).unwrap_err();
    assert!(matches!(refused, ClassifyError::Preprocess(_)));
    let message = described(&refused);
    assert!(
        message.contains("4 points wanted of a cloud of 3"),
        "{message}"
    );
    points[2].y = f32::NAN;
    let message = described(&model.classify(&points, &Vector3::z()).unwrap_err());
    assert!(
        message.contains("point 2") && message.contains("NaN"),
        "{message}"
    );
    assert!(model.classify(&[], &Vector3::z()).is_err());
}

#[test]
fn missing_empty_large_and_corrupt_files_are_named() {
    let load = |path: &PathBuf| described(&Model::load(path, Provider::Cpu, "CPU").unwrap_err());
    let missing = PathBuf::from("/nowhere/model.onnx");
    assert!(load(&missing).contains("cannot read model /nowhere/model.onnx"));
    let good = model_bytes(&Fault::default());
    let cases: [(&[u8], &str); 4] = [
        (b"", "has 0 bytes"),
        (&[0; 100_001], "has 100001 bytes"),
        (b"no model at all, just text", "not a usable ONNX file"),
        (&good[..good.len() / 2], "not a usable ONNX file"),
    ];
    for (bytes, expected) in cases {
        let (_folder, path) = write(bytes);
        let message = load(&path);
        assert!(message.contains(expected), "{message}");
        assert!(message.contains("model.onnx"), "{message}");
    }
}

#[test]
fn a_wrong_interface_is_refused_with_what_was_found() {
    let fault = Fault {
        input: "cloud",
        ..Fault::default()
    };
    let message = refusal(&fault);
    assert!(message.contains("the input is `cloud`"), "{message}");
    let longer = [
        BATCH,
        Dimension::Fixed(3),
        Dimension::Fixed(POINT_COUNT + 1),
    ];
    let fault = Fault {
        input_shape: longer,
        ..Fault::default()
    };
    let message = refusal(&fault);
    assert!(
        message.contains("3, 5") && message.contains("[-1, 3, 4]"),
        "{message}"
    );
    let fault = Fault {
        output: "scores",
        ..Fault::default()
    };
    assert!(refusal(&fault).contains("the output is `scores`"));
    let fault = Fault {
        output_size: 3,
        ..Fault::default()
    };
    assert!(refusal(&fault).contains("[-1, 2]"));
}

#[test]
fn missing_and_wrong_metadata_is_named() {
    for (key, _) in metadata().to_entries() {
        let mut fault = Fault::default();
        fault.entries.retain(|entry| entry.0 != key);
        let message = refusal(&fault);
        assert!(
            message.contains(&format!("metadata key `{key}` is missing")),
            "{message}"
        );
        assert!(message.contains("model.onnx"), "{message}");
    }
    let mut fault = Fault::default();
    fault.entries[1].1 = "-5".to_owned();
    let message = refusal(&fault);
    assert!(message.contains("`point_count` is \"-5\""), "{message}");
}

#[test]
fn openvino_answers_as_the_cpu_does() {
    let (_folder, path) = write(&model_bytes(&Fault::default()));
    let mut cpu = Model::load(&path, Provider::Cpu, "CPU").unwrap();
    let mut openvino = Model::load(&path, Provider::OpenVino, "CPU").unwrap();
    assert_eq!(
        (openvino.provider(), openvino.fallback_reason()),
        ("openvino:CPU", None)
    );
    let points = stick(Vector3::new(0.5, 0.1, 0.45));
    let expected = cpu.classify(&points, &Vector3::z()).unwrap().probabilities;
    let found = openvino
        .classify(&points, &Vector3::z())
        .unwrap()
        .probabilities;
    for (a, b) in expected.iter().zip(&found) {
        assert!((a - b).abs() < 1e-4, "{expected:?} {found:?}");
    }
}

#[test]
fn openvino_can_choose_the_device() {
    let (_folder, path) = write(&model_bytes(&Fault::default()));
    let model = Model::load(&path, Provider::OpenVino, "AUTO").unwrap();
    assert_eq!(
        (model.provider(), model.fallback_reason()),
        ("openvino:AUTO", None)
    );
}

#[test]
fn a_device_that_cannot_start_falls_back_to_the_cpu_and_says_so() {
    let (_folder, path) = write(&model_bytes(&Fault::default()));
    let mut model = Model::load(&path, Provider::OpenVino, "NO_SUCH_DEVICE").unwrap();
    assert_eq!(model.provider(), "cpu");
    let reason = model.fallback_reason().unwrap().to_owned();
    assert!(
        reason.starts_with("openvino:NO_SUCH_DEVICE cannot start: "),
        "{reason}"
    );
    assert_eq!(
        model
            .classify(&stick(Vector3::z()), &Vector3::z())
            .unwrap()
            .label,
        "tall"
    );
}

#[test]
fn large_clouds_are_judged_by_samples_of_their_parts() {
    let model = metadata();
    let line = |count: usize| -> Vec<Point3<f32>> {
        let along = |index| Point3::new(index as f32, 0.0, 0.0);
        (0..count).map(along).collect()
    };
    let parts = |count| preprocess_parts(&line(count), &Vector3::z(), &model).unwrap();
    let few = line(63);
    assert_eq!(
        parts(63),
        preprocess(&few, &Vector3::z(), &model).unwrap(),
        "a small cloud has one part"
    );
    let input = parts(64);
    let samples = input.chunks(3 * POINT_COUNT);
    let mut all_x: Vec<f32> = samples
        .flat_map(|sample| &sample[..POINT_COUNT])
        .copied()
        .collect();
    assert_eq!(all_x.len(), 4 * POINT_COUNT);
    all_x.sort_by(f32::total_cmp);
    all_x.dedup();
    assert_eq!(all_x.len(), 4 * POINT_COUNT, "no point is in two samples");
}

#[test]
fn the_answer_to_several_samples_is_their_mean() {
    let mut model = load_with(&Fault::default()).unwrap();
    let inputs = [Vector3::x(), Vector3::z()]
        .map(|along| preprocess(&stick(along), &Vector3::z(), model.metadata()).unwrap());
    let each = inputs.each_ref().map(|input| model.infer(input).unwrap());
    let together = model.infer(&inputs.concat()).unwrap();
    for class in 0..together.log_probabilities.len() {
        let probability = |output: &Output| f64::from(output.log_probabilities[class]).exp();
        let mean = (probability(&each[0]) + probability(&each[1])) / 2.0;
        assert!(
            (probability(&together) - mean).abs() < 1e-6,
            "class {class}"
        );
    }
}

#[test]
fn normals_of_a_ball_point_away_from_its_centre() {
    let model = ModelMetadata {
        point_count: 60,
        normals: true,
        ..metadata()
    };
    // Points all round a ball by the golden angle.
    let points: Vec<Point3<f32>> = (0..600)
        .map(|index| {
            let z = 1.0 - (2.0 * index as f32 + 1.0) / 600.0;
            let (sin, cos) = (2.399_963 * index as f32).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            Point3::new(0.5 + 0.03 * radius * cos, 0.03 * radius * sin, 0.03 * z)
        })
        .collect();
    let input = preprocess(&points, &Vector3::z(), &model).unwrap();
    assert_eq!(input.len(), 6 * 60);
    for point in 0..60 {
        let column = |row: usize| input[row * 60 + point];
        let outward = Vector3::new(column(0), column(1), column(2)).normalize();
        let normal = Vector3::new(column(3), column(4), column(5));
        assert!((normal.norm() - 1.0).abs() < 1e-5);
        assert!(normal.dot(&outward) > 0.98, "{normal} at {outward}");
    }
}
