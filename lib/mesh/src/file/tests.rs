#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use tempfile::TempDir;

use super::*;

/// Writes a file into a new folder and reads it as a scan in millimetres.
fn read_text(name: &str, text: &str) -> Result<Scan, FileError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    read(path, MILLIMETRE)
}

/// The message, which must name the file.
fn refusal(name: &str, text: &str) -> String {
    let message = read_text(name, text).unwrap_err().to_string();
    assert!(message.contains(name), "{message}");
    message
}

/// A square whose first corner is the origin.
const SQUARE_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
    property double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n\
    element face 1\nproperty list uchar int vertex_index\nend_header\n\
    0 0 0 0 0 2 255\n1000 0 0 0 0 1 255\n1000 1000 0 0 0 1 255\n0 1000 0 0 0 1 255\n4 0 1 2 3\n";

const SQUARE_OBJ: &str = "# made by hand\nmtllib a.mtl\no square\nv 0 0 0\nv 1000 0 0 1.0\nv 1000 1000 0\nv 0 1000 0\n\
    vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 -2//-1 4//1 # a square\n";

fn square(normals: bool) -> Scan {
    Scan {
        points_m: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| Point3::new(x, y, 0.0))
            .to_vec(),
        normals: normals.then(|| vec![Vector3::z(); 4]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        dropped: Dropped::default(),
    }
}

#[test]
fn every_format_gives_the_same_square() {
    assert_eq!(read_text("a.ply", SQUARE_PLY).unwrap(), square(true));
    assert_eq!(read_text("a.OBJ", SQUARE_OBJ).unwrap(), square(true));
    let bare = SQUARE_OBJ.replace("f 1/1/1 2/1/1 -2//-1 4//1", "f 1/1 2 -2 -1");
    assert_eq!(read_text("a.obj", &bare).unwrap(), square(false));
    let windows = SQUARE_OBJ.replace('\n', "\r\n");
    assert_eq!(read_text("a.obj", &windows).unwrap(), square(true));
}

#[test]
fn a_cloud_of_points_may_have_normals() {
    // The first point is at the origin, where a camera saw nothing; as a corner of a face it was.
    let cloud = Scan {
        points_m: square(true).points_m.split_off(1),
        normals: square(true).normals.map(|mut normals| normals.split_off(1)),
        triangles: Vec::new(),
        dropped: Dropped {
            non_finite: 0,
            zero: 1,
        },
    };
    let pcd = "VERSION .7\nFIELDS x y z normal_x normal_y normal_z curvature\nSIZE 4 4 4 4 4 4 4\n\
        TYPE F F F F F F F\nCOUNT 1 1 1 1 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA ascii\n\
        0 0 0 0 0 1 0\n1000 0 0 0 0 1 0\n1000 1000 0 0 0 1 0\n0 1000 0 0 0 3 0\n";
    assert_eq!(read_text("a.pcd", pcd).unwrap(), cloud);
    let obj =
        "v 0 0 0\nvn 0 0 1\nv 1000 0 0\nvn 0 0 1\nv 1000 1000 0\nvn 0 0 1\nv 0 1000 0\nvn 0 0 1\n";
    let read = read_text("a.obj", obj).unwrap();
    assert_eq!(read, cloud);
    assert!(read.is_cloud() && !square(true).is_cloud());
}

#[test]
fn one_normal_without_direction_leaves_none() {
    for bad in ["0 0 0 255", "nan 0 1 255"] {
        let ply = SQUARE_PLY.replace("1000 1000 0 0 0 1 255", &format!("1000 1000 0 {bad}"));
        assert_eq!(read_text("a.ply", &ply).unwrap(), square(false));
    }
}

#[test]
fn what_is_written_is_read_back_with_the_same_bytes_each_time() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("can.ply");
    let mesh = Mesh::cylinder(0.0331, 0.0007, 0.1274, 48);
    write_ply(&path, &mesh).unwrap();
    let bytes = fs::read(&path).unwrap();
    let scan = read(&path, MILLIMETRE).unwrap();
    assert_eq!(scan.triangles, mesh.triangles);
    for (point, vertex) in scan.points_m.iter().zip(&mesh.vertices) {
        assert!((point - vertex).norm() < 2e-8, "{vertex} became {point}");
    }
    write_ply(&path, &mesh).unwrap();
    assert_eq!(fs::read(&path).unwrap(), bytes);
    // What has been through a file once goes through it unchanged.
    write_ply(&path, &scan.mesh()).unwrap();
    assert_eq!(read(&path, MILLIMETRE).unwrap(), scan);
    let left: Vec<PathBuf> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(left, [path]);
}

#[test]
fn obj_files_as_people_have_them_give_the_same_square() {
    let backward = "v 0 0 0\nv 1000 0 0\nv 1000 1000 0\nv 0 1000 0\nf -4 -3 -2 -1\n";
    let files = [
        // The mark hides the first statement, and with it a vertex.
        format!("\u{feff}{backward}"),
        format!("\u{feff}{backward}").replace('\n', "\r\n"),
        backward.replace('\n', "\r"),
        backward
            .replace("v 1000 0 0", "v 1000 \\\n  0 \\\r\n0")
            .replace("-3 -2", "-3\\ \n-2"),
        // Here nothing goes on: the folder's name ends so.
        format!("# C:\\scans\\\nmtllib C:\\scans\\\n{backward}"),
        backward.replace("-4 -3 -2 -1", "1//7 2//8 3//9 4//1"),
        backward.replace("-4 -3 -2 -1", "1/9/ 2/9 3/ 4"),
        format!("f 1 2 3 4\n{}", backward.replace("f -4 -3 -2 -1\n", "")),
        backward.replace("v 1000 1000 0", "v 1.0E3 +1000. 0 255 255 255"),
        format!("g größe\nv nan nan nan\nv 0 0 0\n{backward}"),
    ];
    for file in files {
        let mut read = read_text("a.obj", &file).unwrap();
        let unused = if file.contains("nan") { 1 } else { 0 };
        assert_eq!(
            (read.dropped.non_finite, read.dropped.zero),
            (unused, unused),
            "{file:?}"
        );
        read.dropped = Dropped::default();
        assert_eq!(read, square(false), "{file:?}");
    }
    let latin = [b"# Pr\xFCfstand\n", backward.as_bytes()].concat();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.obj");
    fs::write(&path, latin).unwrap();
    assert_eq!(read(&path, MILLIMETRE).unwrap(), square(false));
    let message = refusal("a.obj", &backward.replace("1000 0 0", "1000,5 0 0"));
    assert!(
        message.contains("line 2") && message.contains("decimal comma"),
        "{message}"
    );
}

#[test]
fn a_written_mesh_cut_anywhere_is_refused() {
    let bytes = ply_bytes(&square(false).mesh());
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("cut.ply");
    for end in 0..bytes.len() {
        fs::write(&path, &bytes[..end]).unwrap();
        let message = read(&path, MILLIMETRE).unwrap_err().to_string();
        assert!(message.contains("cut.ply"), "{end}: {message}");
    }
}

#[test]
fn faces_that_name_missing_vertices_are_refused() {
    for bad in ["4 0 1 2 4", "4 0 1 -1 3"] {
        let ply = SQUARE_PLY.replace("4 0 1 2 3", bad);
        let message = refusal("a.ply", &ply);
        assert!(message.contains("face 0 names vertex"), "{message}");
    }
    for (bad, said) in [
        ("5//1", "vertex 5, of 4"),
        ("0//1", "vertex 0"),
        ("-5//1", "vertex -5"),
        ("x", "\"x\" is no index"),
    ] {
        let message = refusal("a.obj", &SQUARE_OBJ.replace("4//1", bad));
        assert!(
            message.contains(said) && message.contains("line 10"),
            "{message}"
        );
    }
    let message = refusal("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n");
    assert!(message.contains("a face of 2 corners"), "{message}");
}

#[test]
fn bad_coordinates_empty_files_and_units_are_refused_by_name() {
    let message = refusal("a.ply", &SQUARE_PLY.replace("1000 1000 0", "1000 nan 0"));
    assert!(message.contains("vertex 2 of a face"), "{message}");
    let message = refusal("a.obj", &SQUARE_OBJ.replace("v 0 1000 0", "v 0 inf 0"));
    assert!(message.contains("vertex 3 of a face"), "{message}");
    assert!(refusal("a.obj", "v 1 2\n").contains("line 1: fewer than three numbers"));
    assert!(refusal("a.obj", "v 1 2 z\n").contains("\"z\" is no number"));
    assert!(refusal("a.obj", "# nothing\n").contains("no vertices"));
    assert!(refusal("a.stl", "solid").contains("\"stl\" is unknown"));
    for metres_per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = read("a.ply", metres_per_unit).unwrap_err().to_string();
        assert!(message.contains(&metres_per_unit.to_string()), "{message}");
    }
}

#[test]
fn files_that_the_system_refuses_are_named_and_nothing_is_left() {
    for name in ["/nowhere/a.obj", "/nowhere/a.ply"] {
        let message = read(name, MILLIMETRE).unwrap_err().to_string();
        assert!(message.starts_with(name), "{message}");
        let message = write_ply(name, &Mesh::default()).unwrap_err().to_string();
        assert!(
            message.starts_with(name) && message.contains("cannot be written"),
            "{message}"
        );
    }
    let folder = TempDir::new().unwrap();
    let taken = folder.path().join("taken.ply");
    fs::create_dir(&taken).unwrap();
    write_ply(&taken, &Mesh::default()).unwrap_err();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
