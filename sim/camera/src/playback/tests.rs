#![allow(clippy::unwrap_used)]
use super::*;
use std::fs;

fn temporary_folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn natural_order_counts_numbers_by_value() {
    let mut names = ["out_10", "out_2", "out_1", "a", "out_02", "out", "é1", ""];
    names.sort_by(|a, b| natural_order(a, b));
    assert_eq!(
        names,
        ["", "a", "out", "out_1", "out_2", "out_02", "out_10", "é1"]
    );
}

#[test]
fn ply_is_in_the_viewers_frame_and_pcd_in_the_optical_one_unless_told() {
    let folder = temporary_folder();
    cloud::write_ply(
        folder.path().join("view_1.ply"),
        &[Point3::new(0.1, 0.2, -0.3)],
    )
    .unwrap();
    cloud::write_pcd(
        folder.path().join("view_2.PCD"),
        &[Point3::new(0.1, -0.2, 0.3)],
    )
    .unwrap();
    fs::write(folder.path().join("notes.txt"), "not a cloud").unwrap();
    let playback = Playback::open(folder.path(), None).unwrap();
    assert_eq!(playback.captures().len(), 2);
    for capture in playback.captures() {
        assert_eq!(
            capture.points,
            [Point3::new(0.1, -0.2, 0.3)],
            "{}",
            capture.path.display()
        );
    }
    let error = Playback::open(folder.path(), Some(CaptureFrame::Optical)).unwrap_err();
    assert!(
        error.to_string().contains("view_1.ply") && error.to_string().contains("in front"),
        "{error}"
    );
}

#[test]
fn captures_are_shown_in_turn() {
    let folder = temporary_folder();
    for k in [10, 2, 1] {
        cloud::write_pcd(
            folder.path().join(format!("out_{k}.pcd")),
            &[Point3::new(0.0, 0.0, k as f32)],
        )
        .unwrap();
    }
    let mut playback = Playback::open(folder.path(), None).unwrap();
    assert_eq!(playback.current().points[0].z, 1.0);
    let shown: Vec<f32> = (0..4).map(|_| playback.advance().points[0].z).collect();
    assert_eq!(shown, [1.0, 2.0, 10.0, 1.0]);
}

#[test]
fn each_point_is_in_its_pixel_and_the_nearest_wins() {
    let camera = crate::D435I;
    let at = |u: f64, v: f64, z_m: f64| crate::deproject(&camera, [u, v], z_m).cast::<f32>();
    let points = vec![
        at(100.0, 50.0, 0.5),
        at(100.2, 50.2, 0.4),
        at(99.8, 50.0, 0.6),
        at(0.0, 479.0, 1.0),
        at(-1.0, 10.0, 1.0),
        at(848.0, 10.0, 1.0),
        at(300.0, 10.0, 70.0),
    ];
    let image = Capture {
        path: PathBuf::new(),
        points,
    }
    .depth_image(&camera);
    assert_eq!((image.at(100, 50), image.at(0, 479)), (400, 1000));
    assert_eq!(image.depth_mm.iter().filter(|&&depth| depth > 0).count(), 2);
}

#[test]
fn what_cannot_be_played_is_named() {
    let folder = temporary_folder();
    let missing = folder.path().join("nowhere");
    let error = Playback::open(&missing, None).unwrap_err();
    assert!(
        matches!(error, PlaybackError::Folder { .. }) && error.to_string().contains("nowhere"),
        "{error}"
    );

    let error = Playback::open(folder.path(), None).unwrap_err();
    assert!(matches!(error, PlaybackError::NoFiles { .. }), "{error}");

    fs::write(folder.path().join("broken.ply"), "ply\nformat ascii 1.0\n").unwrap();
    let error = Playback::open(folder.path(), None).unwrap_err();
    assert!(
        matches!(error, PlaybackError::File(_)) && error.to_string().contains("broken.ply"),
        "{error}"
    );
}
