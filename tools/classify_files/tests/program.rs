//! The tool on files, good and bad, as a user runs it.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use nalgebra::Point3;
use serde_json::Value;
use tempfile::TempDir;

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_classify_files"))
        .args(arguments)
        .output()
        .unwrap()
}

fn refusal(arguments: &[&str], exit_code: i32) -> String {
    let output = run(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(exit_code), "{message}");
    assert!(output.stdout.is_empty());
    message
}

/// The upright wall of a cylinder with the size of a can, all round, in a file.
fn can_file(folder: &TempDir, name: &str, unit_m: f32) -> PathBuf {
    let (radius_m, height_m) = (0.0327, 0.127);
    let points: Vec<Point3<f32>> = (0..48)
        .flat_map(|turn| (0..64).map(move |level| (turn as f32, level as f32)))
        .map(|(turn, level)| {
            let (sin, cos) = (turn / 48.0 * std::f32::consts::TAU).sin_cos();
            Point3::new(
                radius_m * cos,
                radius_m * sin,
                0.3 + height_m * level / 63.0,
            ) / unit_m
        })
        .collect();
    let path = folder.path().join(name);
    cloud::write_ply(&path, &points).unwrap();
    path
}

#[test]
fn json_has_what_the_contract_names() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a.ply", "b.ply"].map(|name| can_file(&folder, name, 1.0));
    let [a, b] = [files[0].to_str().unwrap(), files[1].to_str().unwrap()];
    let output = run(&["--json", a, b]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(answer["label"].is_string() && answer["known"].is_boolean());
    let probabilities = answer["probabilities"].as_object().unwrap();
    let sum: f64 = probabilities.values().map(|p| p.as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-6 && probabilities.len() == 8);
    for stage in ["register", "crop", "sample", "infer", "total"] {
        assert!(
            answer["timing_ms"][stage].as_f64().unwrap() >= 0.0,
            "{stage}"
        );
    }
    let views = answer["views"].as_array().unwrap();
    assert_eq!(views.len(), 2);
    for view in views {
        assert!(view["fitness"].is_f64() && view["rmse_m"].is_f64());
        assert!(view["iterations"].is_u64());
        assert_eq!(view["dropped_points"], 0);
        assert_eq!(view["transform"].as_array().unwrap().len(), 4);
    }
}

#[test]
fn millimetres_and_metres_give_the_same_answer() {
    let folder = tempfile::tempdir().unwrap();
    let label = |file: PathBuf, units: &str| {
        let output = run(&["--json", "--units", units, file.to_str().unwrap()]);
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        answer["label"].as_str().unwrap().to_owned()
    };
    let metres = label(can_file(&folder, "m.ply", 1.0), "m");
    assert_eq!(label(can_file(&folder, "mm.ply", 0.001), "mm"), metres);
}

#[test]
fn deformation_is_measured_on_request_by_the_names_of_its_message() {
    let folder = tempfile::tempdir().unwrap();
    let can = can_file(&folder, "can.ply", 1.0);
    let can = can.to_str().unwrap();
    let answer = |arguments: &[&str]| -> Value {
        let output = run(&[&["--json", can], arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    assert!(answer(&[]).get("deformation").is_none());
    let shipped = answer(&["--deformation"])["deformation"].clone();
    assert!(shipped["dents"].is_array() && shipped["fits"].is_boolean());
    let summary = shipped["summary"].as_str().unwrap();
    let text = run(&["--deformation", can]);
    assert!(String::from_utf8(text.stdout).unwrap().contains(summary));

    let none = folder.path().join("none");
    std::fs::create_dir(&none).unwrap();
    let without = answer(&["--deformation", "--references", none.to_str().unwrap()]);
    assert_eq!(without["deformation"]["fits"], false);
    assert!(
        !without["deformation"]["reason"]
            .as_str()
            .unwrap()
            .is_empty()
    );
    let message = refusal(&["--deformation", "--references", "/no/such", can], 1);
    assert!(message.contains("/no/such"), "{message}");
    let message = refusal(&["--deformation", "--viewpoint", "0,0", can], 2);
    assert!(message.contains("three numbers"), "{message}");
    assert!(refusal(&["--viewpoint", "0,0,0", can], 2).contains("--deformation"));
}

#[test]
fn wrong_usage_exits_with_2_and_says_what_is_wrong() {
    assert!(refusal(&[], 2).contains("FILE"));
    assert!(refusal(&["--up", "up", "x.ply"], 2).contains("\"up\" is no axis"));
    assert!(refusal(&["--units", "inch", "x.ply"], 2).contains("inch"));
    assert!(refusal(&["--provider", "cuda", "x.ply"], 2).contains("openvino"));
    let message = refusal(&["--initial-guess", "kinematic", "x.ply"], 2);
    assert!(message.contains("use identity"), "{message}");
}

#[test]
fn what_cannot_be_classified_exits_with_1_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    assert!(refusal(&["/nowhere/a.ply"], 1).contains("/nowhere/a.ply"));
    assert!(refusal(&["--model", "/nowhere/m.onnx", "x.ply"], 1).contains("/nowhere/m.onnx"));

    let can = can_file(&folder, "can.ply", 1.0);
    let can = can.to_str().unwrap();
    let message = refusal(&["--keep-above", "5", can], 1);
    assert!(
        message.contains("nothing of the object is left"),
        "{message}"
    );
    let message = refusal(&["--keep-above", "0.4245", can], 1);
    assert!(message.contains("points wanted of a cloud of"), "{message}");

    let bytes = std::fs::read(can).unwrap();
    let truncated = folder.path().join("truncated.ply");
    std::fs::write(&truncated, &bytes[..bytes.len() / 2]).unwrap();
    let message = refusal(&[truncated.to_str().unwrap()], 1);
    assert!(
        message.contains("truncated.ply: ends too early"),
        "{message}"
    );
}

/// Three views of a can that is pressed flat on one side and stands on a box; it was turned a few tens of degrees from one to the next.
/// Nobody measured its dent. The three answers come about independently, and have to agree with each other and with the registration.
#[test]
#[ignore = "needs real data: DEFORMABLE_COBOT_REAL names the folder, ../shared/real by default"]
fn three_views_of_a_real_can_tell_of_the_same_dent() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let real = std::env::var_os("DEFORMABLE_COBOT_REAL").map_or_else(beside, PathBuf::from);
    let views = [1, 2, 3].map(|number| real.join(format!("captures/can_a/out_{number}.ply")));
    let views = views.each_ref().map(|view| view.to_str().unwrap());
    let answer = |files: &[&str]| -> Value {
        let box_away = ["--json", "--up=+y", "--keep-above=-0.115"];
        let deformation = ["--deformation", "--viewpoint", "0,0,0"];
        let output = run(&[files, &box_away, &deformation].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let numbers = |value: &Value| -> Vec<f64> {
        let list = value.as_array().unwrap().iter();
        list.map(|number| number.as_f64().unwrap()).collect()
    };
    let dents = views.map(|view| {
        let deformation = answer(&[view])["deformation"].clone();
        println!("{view}: {}", deformation["summary"]);
        assert_eq!(deformation["fits"], true);
        deformation["dents"][0].clone()
    });
    let depths_m = dents.each_ref().map(|dent| dent["depth"].as_f64().unwrap());
    let heights_m = dents
        .each_ref()
        .map(|dent| numbers(&dent["centre_in_object"])[2]);
    let apart_m = |values: [f64; 3]| {
        values.into_iter().fold(f64::MIN, f64::max) - values.into_iter().fold(f64::MAX, f64::min)
    };
    assert!(depths_m.iter().all(|depth_m| *depth_m > 0.008));
    assert!(apart_m(depths_m) < 0.002, "{depths_m:?}");
    assert!(apart_m(heights_m) < 0.008, "{heights_m:?}");
    // About +y, by which way the dent faces, and by how the views were laid onto each other.
    let dent_turned_rad = |dent: &Value| {
        let direction = numbers(&dent["direction"]);
        direction[0].atan2(direction[2])
    };
    let whole = answer(&views);
    for index in 1..3 {
        let rows = whole["views"][index]["transform"].as_array().unwrap();
        let turned_rad = numbers(&rows[0])[2].atan2(numbers(&rows[2])[2]);
        let by_dent_rad = dent_turned_rad(&dents[0]) - dent_turned_rad(&dents[index]);
        println!("view {index}: {turned_rad:.3} rad, by its dent {by_dent_rad:.3} rad");
        assert!((turned_rad - by_dent_rad).abs() < 0.15);
    }
}
