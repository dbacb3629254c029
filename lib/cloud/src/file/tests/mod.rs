#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use nalgebra::Point3;
use tempfile::TempDir;

use super::*;

/// A folder that holds one file.
struct Fixture {
    _folder: TempDir,
    path: PathBuf,
}

fn file(name: &str, bytes: &[u8]) -> Fixture {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    Fixture {
        _folder: folder,
        path,
    }
}

fn read_bytes(name: &str, bytes: &[u8]) -> Result<Cloud, FileError> {
    read(file(name, bytes).path)
}

/// The message, which must name the file.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let message = read_bytes(name, bytes).unwrap_err().to_string();
    assert!(message.contains(name), "{message}");
    message
}

const POINTS: [Point3<f32>; 2] = [Point3::new(0.5, -0.25, 0.125), Point3::new(1.0, 2.0, -3.0)];

const ASCII_PLY: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 2\nproperty double x\n\
    property uchar red\nproperty float y\nproperty float z\nproperty list uchar int tags\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0.5 7 -0.25 0.125 2 4 5\n1 8 2 -3 0\n3 0 1 1\n";

/// Vertices with a colour between the coordinates, and a face.
fn binary_ply(encoding: &str, little_endian: bool) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 2\nproperty float32 x\nproperty uint8 red\nproperty float32 y\n\
         property float32 z\nelement face 1\nproperty list uint8 int32 vertex_indices\nend_header\n"
    )
    .into_bytes();
    let float = |value: f32| {
        if little_endian {
            value.to_le_bytes()
        } else {
            value.to_be_bytes()
        }
    };
    let int = |value: i32| {
        if little_endian {
            value.to_le_bytes()
        } else {
            value.to_be_bytes()
        }
    };
    for point in POINTS {
        bytes.extend(float(point.x));
        bytes.push(200);
        bytes.extend(float(point.y));
        bytes.extend(float(point.z));
    }
    bytes.push(3);
    bytes.extend([0, 1, 1].into_iter().flat_map(int));
    bytes
}

const ASCII_PCD: &str = "# .PCD v.7\nVERSION 0.7\nFIELDS rgb x y z\nSIZE 4 4 8 4\nTYPE U F F F\nCOUNT 1 1 1 1\n\
    WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n99 0.5 -0.25 0.125\n98 1 2 -3\n";

#[test]
fn every_kind_of_ply_gives_the_same_points() {
    let little = binary_ply("binary_little_endian", true);
    let big = binary_ply("binary_big_endian", false);
    for bytes in [ASCII_PLY.as_bytes(), &little, &big] {
        assert_eq!(read_bytes("view.PLY", bytes).unwrap().points, POINTS);
    }
    let windows = ASCII_PLY.replace('\n', "\r\n");
    assert_eq!(
        read_bytes("view.ply", windows.as_bytes()).unwrap().points,
        POINTS
    );
}

#[test]
fn ascii_pcd_with_extra_fields_is_read() {
    assert_eq!(
        read_bytes("view.pcd", ASCII_PCD.as_bytes()).unwrap().points,
        POINTS
    );
}

#[test]
fn what_is_written_is_read_back() {
    let folder = TempDir::new().unwrap();
    let (ply, pcd) = (folder.path().join("a.ply"), folder.path().join("a.pcd"));
    write_ply(&ply, &POINTS).unwrap();
    write_pcd(&pcd, &POINTS).unwrap();
    assert_eq!(read(&ply).unwrap().points, POINTS);
    assert_eq!(read(&pcd).unwrap().points, POINTS);
    write_pcd_field(&pcd, &POINTS, "deviation", &[0.5; POINTS.len()]).unwrap();
    assert_eq!(read(&pcd).unwrap().points, POINTS);
    let text = fs::read(&pcd).unwrap();
    assert!(String::from_utf8_lossy(&text).contains("FIELDS x y z deviation"));
    write_ply(&ply, &[]).unwrap();
    write_pcd(&pcd, &[]).unwrap();
    assert_eq!(read(&ply).unwrap(), Cloud::default());
    assert_eq!(read(&pcd).unwrap(), Cloud::default());
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "a temporary file was left behind"
    );
}

#[test]
fn compressed_pcd_is_read_and_lies_about_its_size_are_refused() {
    let mut bytes = ASCII_PCD.replace("ascii", "binary_compressed").into_bytes();
    bytes.truncate(bytes.iter().rposition(|&byte| byte == b'd').unwrap() + 2);
    let header = bytes.clone();
    // Column by column; LZF: a byte n < 32 says that n + 1 plain bytes follow.
    let mut columns = Vec::new();
    columns.extend([99_u32, 98].into_iter().flat_map(u32::to_le_bytes));
    columns.extend(POINTS.iter().flat_map(|point| point.x.to_le_bytes()));
    columns.extend(
        POINTS
            .iter()
            .flat_map(|point| f64::from(point.y).to_le_bytes()),
    );
    columns.extend(POINTS.iter().flat_map(|point| point.z.to_le_bytes()));
    let packed: Vec<u8> = columns
        .chunks(32)
        .flat_map(|part| [&[part.len() as u8 - 1], part].concat())
        .collect();
    bytes.extend((packed.len() as u32).to_le_bytes());
    bytes.extend((columns.len() as u32).to_le_bytes());
    bytes.extend(&packed);
    assert_eq!(read_bytes("view.pcd", &bytes).unwrap().points, POINTS);

    let mut short = header.clone();
    short.extend([4_u32, 8].into_iter().flat_map(u32::to_le_bytes));
    short.extend([1, 0, 0, 0]);
    assert!(refusal("view.pcd", &short).contains("ends too early"));
    let mut huge = header;
    huge.extend([4_u32, u32::MAX].into_iter().flat_map(u32::to_le_bytes));
    huge.extend([1, 0, 0, 0]);
    assert!(refusal("view.pcd", &huge).contains("cannot unpack"));
}

#[test]
fn files_cut_at_every_byte_are_refused() {
    let pcd = pcd::encode(&POINTS, None).unwrap();
    let files = [
        ("view.ply", binary_ply("binary_little_endian", true)),
        ("view.ply", binary_ply("binary_big_endian", false)),
        ("view.pcd", pcd),
    ];
    for (name, bytes) in files {
        for end in 0..bytes.len() {
            let message = refusal(name, &bytes[..end]);
            let header_end = bytes
                .windows(4)
                .position(|word| word == b"ader" || word == b"DATA")
                .unwrap();
            let is_whole_header = end > header_end + 20;
            assert!(
                !is_whole_header || message.contains("ends too early"),
                "{end}: {message}"
            );
        }
    }
    for (name, text) in [("view.ply", ASCII_PLY), ("view.pcd", ASCII_PCD)] {
        let lines: Vec<_> = text.split_inclusive('\n').collect();
        for end in 0..lines.len() {
            assert!(!refusal(name, lines[..end].concat().as_bytes()).is_empty());
        }
    }
}

#[test]
fn nan_and_zero_points_are_dropped_and_counted() {
    for word in ["nan", "-NaN", "-nan(ind)", "inf", "-Infinity"] {
        let ply = ASCII_PLY.replace("1 8 2 -3 0", &format!("1 8 {word} -3 0"));
        let cloud = read_bytes("view.ply", ply.as_bytes()).unwrap();
        assert_eq!(
            (
                cloud.points.len(),
                cloud.dropped.non_finite,
                cloud.dropped.zero
            ),
            (1, 1, 0),
            "{word}"
        );
    }
    let pcd = ASCII_PCD.replace("98 1 2 -3", "98 0 0 -0");
    let cloud = read_bytes("view.pcd", pcd.as_bytes()).unwrap();
    assert_eq!(
        (
            cloud.points.len(),
            cloud.dropped.non_finite,
            cloud.dropped.zero
        ),
        (1, 0, 1)
    );
}

#[test]
fn files_without_coordinates_say_what_they_have() {
    let ply = ASCII_PLY.replace("float y", "float v");
    assert!(refusal("view.ply", ply.as_bytes()).contains("x, red, v, z, tags"));
    let ply = ASCII_PLY.replace("element vertex", "element point");
    assert!(refusal("view.ply", ply.as_bytes()).contains("elements [point, face]"));
    let pcd = ASCII_PCD.replace("rgb x y z", "rgb x y w");
    assert!(refusal("view.pcd", pcd.as_bytes()).contains("rgb, x, y, w"));
}

#[test]
fn absurd_counts_are_refused_at_once() {
    let binary = binary_ply("binary_little_endian", true);
    let at = binary
        .windows(8)
        .position(|word| word == b"vertex 2")
        .unwrap();
    let huge = [&binary[..at], b"vertex 4000000000000", &binary[at + 8..]].concat();
    assert!(refusal("view.ply", &huge).contains("ends too early"));
    let pcd = ASCII_PCD.replace("POINTS 2", "POINTS 4000000000000");
    assert!(refusal("view.pcd", pcd.as_bytes()).contains("ends too early"));
    let pcd = ASCII_PCD
        .replace("rgb x", "_ x")
        .replace("COUNT 1", "COUNT 9000000000000")
        .replace("ascii", "binary");
    assert!(refusal("view.pcd", pcd.as_bytes()).contains("ends too early"));
}

#[test]
fn other_refusals_name_the_file_too() {
    assert!(refusal("view.obj", b"").contains("\"obj\" is unknown"));
    assert!(refusal("view.ply", b"solid cube\n").contains("no valid PLY file"));
    assert!(refusal("view.pcd", b"VERSION 0.3\nDATA ascii\n").contains("no valid PCD file"));
    let message = read("/nowhere/view.ply").unwrap_err().to_string();
    assert!(
        message.starts_with("/nowhere/view.ply: cannot be read"),
        "{message}"
    );
    let message = write_ply("/nowhere/view.ply", &POINTS)
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("/nowhere/view.ply: cannot be written"),
        "{message}"
    );
}

mod people;
