#![allow(clippy::unwrap_used)]

use std::path::Path;

use super::*;

fn clouds(columns: usize) -> LabelledClouds {
    let mut clouds = LabelledClouds::new(2, columns);
    for label in 0..7 {
        let taken = [
            1.0,
            2.0,
            3.0,
            4.0,
            5.0,
            label as f32,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0,
            1.0,
        ];
        let seen = Seen {
            label,
            view_count: 3,
            held: true,
            taken: taken[..2 * columns].to_vec(),
        };
        let split = if label < 5 { Split::Train } else { Split::Test };
        clouds.push(&seen, 0.5, split);
    }
    clouds
}

#[test]
fn input_is_transposed_and_put_into_metres() {
    assert_eq!(clouds(3).cloud(6), [0.5, 1.5, 2.5, 1.0, 2.0, 3.0]);
    let with_normals = [0.5, 1.5, 2.5, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 1.0];
    assert_eq!(clouds(6).cloud(6), with_normals);
    let tensor = clouds(6).tensor(&[6], 0.5, None).unwrap();
    let units = tensor.flatten_all().unwrap().to_vec1::<f32>().unwrap();
    assert_eq!(
        units,
        [1.0, 3.0, 5.0, 0.0, 0.0, 1.0, 2.0, 4.0, 6.0, 0.0, 0.0, 1.0]
    );
}

#[test]
fn a_part_has_the_clouds_of_its_split_and_their_first_points() {
    let part = clouds(3).part(Split::Test, 1);
    assert_eq!((part.len(), part.point_count), (2, 1));
    assert_eq!(part.labels, [5, 6]);
    assert_eq!(part.cloud(1), [0.5, 1.5, 2.5]);
    assert!(clouds(3).part(Split::Validation, 2).is_empty());
}

#[test]
fn files_read_back_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for columns in [3, 6] {
        let path = folder.path().join("made/clouds.npz");
        clouds(columns).write(&path, "code").unwrap();
        let read = LabelledClouds::read(&path).unwrap();
        assert_eq!(read, (clouds(columns), "code".to_owned()));
        let entries = std::fs::read_dir(path.parent().unwrap()).unwrap();
        assert_eq!(entries.count(), 1);
    }
}

#[test]
fn what_other_code_made_is_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clouds.npz");
    assert_eq!(LabelledClouds::read_own(&path, "code").unwrap(), None);
    clouds(3).write(&path, "code").unwrap();
    let own = LabelledClouds::read_own(&path, "code").unwrap();
    assert_eq!(own, Some(clouds(3)));
    assert_eq!(LabelledClouds::read_own(&path, "other").unwrap(), None);
}

#[test]
fn a_truncated_or_foreign_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clouds.npz");
    clouds(3).write(&path, "code").unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for bytes in [&bytes[..bytes.len() / 2], b"text"] {
        std::fs::write(&path, bytes).unwrap();
        let message = LabelledClouds::read(&path).unwrap_err().to_string();
        assert!(message.contains("clouds.npz"), "{message}");
    }
    assert!(LabelledClouds::read(Path::new("/nowhere/clouds.npz")).is_err());
}
