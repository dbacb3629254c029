//! Objects from recorded views, and views that are refused.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use nalgebra::Point3;
use std::f32::consts::TAU;
use std::sync::atomic::AtomicBool;
use teach::look::Watch;
use teach::views;

/// A tapered, bent can of which one side is seen, about `towards` (rad), by a third of a turn.
fn side(towards: f32, at_x: f32) -> Vec<Point3<f32>> {
    let point = |k: usize, level: usize| {
        let angle = towards + (k as f32 / 60.0 - 0.5) * TAU / 2.2;
        let height = level as f32 / 50.0;
        let radius = 0.03 + 0.008 * height + 0.004 * (3.0 * angle).cos();
        Point3::new(
            at_x + radius * angle.cos(),
            radius * angle.sin(),
            0.1 * height,
        )
    };
    (0..60)
        .flat_map(|k| (0..50).map(move |level| point(k, level)))
        .collect()
}

fn object_of(files: &[PathBuf]) -> anyhow::Result<Vec<Point3<f32>>> {
    let watch = Watch {
        finished: &|| {},
        stop: &AtomicBool::new(false),
    };
    views::object_of(files, 1.0, &watch)
}

fn written(folder: &Path, views: &[Vec<Point3<f32>>]) -> Vec<PathBuf> {
    let file = |(number, points): (usize, &Vec<Point3<f32>>)| {
        let path = folder.join(format!("view_{number}.ply"));
        cloud::write_ply(&path, points).unwrap();
        path
    };
    views.iter().enumerate().map(file).collect()
}

#[test]
fn views_of_all_sides_make_an_object_and_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let views: Vec<Vec<Point3<f32>>> = (0..6).map(|k| side(TAU * k as f32 / 6.0, 0.0)).collect();
    let files = written(folder.path(), &views);
    let points = object_of(&files).unwrap();
    let bounds = cloud::bounds(&points).unwrap().extent();
    assert!(
        (bounds.z - 0.098).abs() < 0.004 && bounds.x > 0.07,
        "{bounds}"
    );

    let refusal = |files: &[PathBuf], words: &str| {
        let said = format!("{:#}", object_of(files).unwrap_err());
        assert!(said.contains(words), "{said}");
    };
    refusal(&files[..2], "2 views are too few");
    refusal(&files[..3], "add views of the other side");
    let two: Vec<Vec<Point3<f32>>> = (0..6)
        .map(|k| TAU * k as f32 / 6.0)
        .map(|towards| [side(towards, 0.0), side(towards, 0.12)].concat())
        .collect();
    refusal(&written(folder.path(), &two), "2 objects are in view");
    std::fs::write(folder.path().join("scan.yaml"), "views: 3").unwrap();
    refusal(&files, "scan.yaml is not as scan --save writes it");
    let one = "views: [{file: view_0.ply, hand_from_camera: {translation_m: [0, 0, 0], rotation: [0, 0, 0, 1]}}]";
    std::fs::write(folder.path().join("scan.yaml"), one).unwrap();
    refusal(&files, "view_5.ply has no pose of the hand");
}
