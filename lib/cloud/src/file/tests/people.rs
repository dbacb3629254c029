//! Files as other programs write them and people edit them: each variant has the same points as the plain file.

use super::*;

fn points(name: &str, bytes: impl AsRef<[u8]>) -> Vec<Point3<f32>> {
    read_bytes(name, bytes.as_ref()).unwrap().points
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n";
const ROWS: &str = "0.5 -0.25 0.125\n1 2 -3\n";

/// A PLY file of these points whose header has more lines.
fn ply(more: &str, rows: &str) -> String {
    format!("{HEADER}{more}end_header\n{rows}")
}

#[test]
fn white_space_is_white_space() {
    let colour = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    // RealSense's text export breaks the line between coordinates and colour.
    let files = [
        ply(colour, "0.5 -0.25 0.125 \n9 8 7 \n1 2 -3 \n6 5 4 \n"),
        ply(colour, "0.5 -0.25\n0.125 9 8 7 1 2 -3 6 5 4"),
        ply(
            colour,
            "\r\n\n0.5\t-0.25 0.125 9 8 7\r\n\r\n1 2 -3 6 5 4\n\n\x1a",
        ),
        ply(
            "element face 1\nproperty list uchar int vertex_index\n",
            "\n0.5 -0.25 0.125\n1 2 -3\n\n3 0 1 1\n",
        ),
        ply("", ROWS).replace('\n', "\r"),
        ply("", ROWS).replace('\n', "\r\n"),
        ply("\n  \ncomment\n", ROWS),
        ply("", ROWS).replace("format", "\nobj_info num_cols 2\n  format"),
    ];
    for file in files {
        assert_eq!(points("view.ply", &file), POINTS, "{file:?}");
    }
    let pcd = ASCII_PCD
        .replace("125\n98", "125\n\n98")
        .replace("0.5 -", "\n0.5\t-");
    assert_eq!(points("view.pcd", &pcd), POINTS);
    assert_eq!(points("view.pcd", pcd.replace('\n', "\r\n")), POINTS);
}

#[test]
fn an_empty_line_before_binary_data_is_no_data() {
    for (encoding, is_little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let plain = binary_ply(encoding, is_little);
        let end = plain.windows(4).position(|word| word == b"ader").unwrap() + 5;
        for gap in ["\n", "\r", "\r\n"] {
            let file = [&plain[..end], gap.as_bytes(), &plain[end..]].concat();
            assert_eq!(points("view.ply", &file), POINTS, "{gap:?}");
        }
        // Here the line feed is the first byte of a number.
        let mut begins = plain.clone();
        begins[end] = b'\n';
        assert_eq!(read_bytes("view.ply", &begins).unwrap().points.len(), 2);
        assert_eq!(points("view.ply", &begins)[1], POINTS[1]);
    }
}

#[test]
fn columns_that_are_not_needed_are_skipped() {
    // CloudCompare keeps the parentheses of its fields' names; others write names with spaces, or in other letters.
    for name in [
        "scalar_C2C_absolute_distances_(XY)",
        "my field",
        "größe",
        "-",
        "x2",
    ] {
        for kind in ["float", "uchar", "uint64", "half", "list uchar float"] {
            let column = format!("property {kind} {name}\n");
            let rows = match kind.starts_with("list") {
                true => "0.5 -0.25 0.125 2 7 7\n1 2 -3 0\n",
                false => "0.5 -0.25 0.125 255.0\n1 2 -3 -\n",
            };
            assert_eq!(
                points("view.ply", ply(&column, rows)),
                POINTS,
                "{kind} {name}"
            );
        }
    }
    let other = "element camera 1\nproperty float view_px\nproperty list uchar int cells\n";
    let file = ply(other, "0.5 -0.25 0.125\n1 2 -3\n0.1 3 1 2 3\n");
    assert_eq!(points("view.ply", file), POINTS);
    let pcd = ASCII_PCD
        .replace("rgb", "größe(XY)")
        .replace("99 ", "4.2e6 ");
    assert_eq!(points("view.pcd", pcd), POINTS);
    assert_eq!(
        points("view.ply", ply("", ROWS).replace("float x", "FLOAT X")),
        POINTS
    );
    assert_eq!(
        points("view.pcd", ASCII_PCD.replace("x y z", "X Y Z")),
        POINTS
    );
}

#[test]
fn text_before_the_numbers_may_be_in_any_encoding() {
    let remark = b"comment Pr\xFCfstand 3, K\xFCvette\n";
    for plain in [
        ply("", ROWS).into_bytes(),
        binary_ply("binary_little_endian", true),
    ] {
        let at = plain
            .windows(7)
            .position(|word| word == b"element")
            .unwrap();
        let file = [&plain[..at], remark, &plain[at..]].concat();
        assert_eq!(points("view.ply", &file), POINTS);
        let marked = [b"\xEF\xBB\xBF", file.as_slice()].concat();
        assert_eq!(points("view.ply", &marked), POINTS);
    }
    let plain = pcd::encode(&POINTS, None).unwrap();
    for plain in [&plain, ASCII_PCD.as_bytes()] {
        let file = [b"# Pr\xFCfstand 3\n", plain].concat();
        assert_eq!(points("view.pcd", &file), POINTS);
        let marked = [b"\xEF\xBB\xBF", file.as_slice()].concat();
        assert_eq!(points("view.pcd", &marked), POINTS);
    }
    let utf16: Vec<u8> = ply("", ROWS)
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let message = refusal("view.ply", &[b"\xFF\xFE", utf16.as_slice()].concat());
    assert!(
        message.contains("UTF-16") && message.contains("save it as UTF-8"),
        "{message}"
    );
}

#[test]
fn numbers_are_read_as_programs_print_them() {
    let odd = ply(
        "property uchar red\n",
        "5.0E-1 -.25 +0.125 1.0\n1. 2.0e0 -3 2\n",
    );
    assert_eq!(points("view.ply", odd), POINTS);
    for word in [
        "nan",
        "-nan(ind)",
        "1.#QNAN",
        "-1.#IND00",
        "1.#INF",
        "-inf",
        "1e999",
    ] {
        let cloud = read_bytes("view.ply", ply("", &ROWS.replace("-3", word)).as_bytes()).unwrap();
        assert_eq!(
            (cloud.points.len(), cloud.dropped.non_finite),
            (1, 1),
            "{word}"
        );
    }
    let message = refusal("view.ply", ply("", &ROWS.replace("0.5", "0,5")).as_bytes());
    assert!(
        message.contains("decimal comma") && !message.contains("export it again"),
        "{message}"
    );
}

#[test]
fn a_header_that_does_not_describe_the_rows_is_no_reason_for_wrong_points() {
    let message = refusal(
        "view.ply",
        ply("", "0.5 -0.25 0.125 1\n1 2 -3 1\n").as_bytes(),
    );
    assert!(
        message.contains("more numbers than its header announces"),
        "{message}"
    );
    let message = refusal("view.ply", ply("propertyx float w\n", ROWS).as_bytes());
    assert!(
        message.contains("line 7") && message.contains("propertyx float w"),
        "{message}"
    );
    let pcd = ASCII_PCD.replace("POINTS 2", "POINTS 1");
    let message = refusal("view.pcd", pcd.as_bytes());
    assert!(
        message.contains("8 numbers") && message.contains("POINTS"),
        "{message}"
    );
}

/// A binary PCD file of points between padding, as PCL keeps them in memory.
fn padded_pcd(points: &[Point3<f32>], spare: &str, counts: &str, tail: usize) -> Vec<u8> {
    let mut bytes = format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z _ rgb {spare}\nSIZE 4 4 4 1 4 1 2 1\nTYPE F F F U F U U U\n\
         COUNT 1 1 1 4 1 {counts}\nWIDTH {}\nHEIGHT 2\nPOINTS {}\nDATA binary\n",
        points.len() / 2,
        points.len()
    )
    .into_bytes();
    for point in points {
        bytes.extend(point.iter().flat_map(|coordinate| coordinate.to_le_bytes()));
        bytes.extend(std::iter::repeat_n(90, 8 + tail));
    }
    bytes
}

#[test]
fn an_organised_cloud_has_cells_without_a_measurement() {
    let nowhere = Point3::new(f32::NAN, f32::NAN, f32::NAN);
    let cells = [nowhere, POINTS[0], Point3::origin(), POINTS[1]];
    let file = padded_pcd(&cells, "_ rgb _", "0 1 9", 11);
    let cloud = read_bytes("view.pcd", &file).unwrap();
    assert_eq!(cloud.points, POINTS);
    assert_eq!((cloud.dropped.non_finite, cloud.dropped.zero), (1, 1));
    let surface = read_surface(self::file("view.pcd", &file).path).unwrap();
    assert_eq!(surface.points, POINTS);
    assert_eq!((surface.dropped.non_finite, surface.dropped.zero), (1, 1));
}

#[test]
fn a_count_of_zero_is_what_the_length_of_the_file_says() {
    // The padding takes no byte in the first file, and one for each point in the second.
    assert_eq!(
        points("view.pcd", padded_pcd(&POINTS, "_ a _", "0 1 9", 11)),
        POINTS
    );
    assert_eq!(
        points("view.pcd", padded_pcd(&POINTS, "_ a _", "0 1 9", 12)),
        POINTS
    );
    for tail in [10, 13] {
        let message = refusal("view.pcd", &padded_pcd(&POINTS, "_ a _", "0 1 9", tail));
        assert!(message.contains("COUNT"), "{message}");
    }
    let text = ASCII_PCD
        .replace("rgb x y z", "_ rgb x y z")
        .replace("COUNT 1", "COUNT 0 1");
    let text = text.replace("SIZE", "SIZE 1").replace("TYPE", "TYPE U");
    assert_eq!(points("view.pcd", &text), POINTS);
    assert_eq!(
        points("view.pcd", text.replace("99", "1 99").replace("98", "1 98")),
        POINTS
    );
    // PCL's own text has no columns for padding.
    assert_eq!(
        points("view.pcd", text.replace("COUNT 0", "COUNT 3")),
        POINTS
    );
}

#[test]
fn what_old_headers_leave_out_has_the_defaults_of_pcl() {
    let old = "COLUMNS x y z\nPOINTS 2\nDATA ascii\n0.5 -0.25 0.125\n1 2 -3\n";
    assert_eq!(points("view.pcd", old), POINTS);
    assert_eq!(
        points("view.pcd", old.replace("POINTS 2", "WIDTH 1\nHEIGHT 2")),
        POINTS
    );
    let twice = ASCII_PCD
        .replace("rgb x y z", "a a x y z")
        .replace("SIZE", "SIZE 2");
    let twice = twice
        .replace("TYPE", "TYPE U")
        .replace("COUNT", "COUNT 1")
        .replace("9 0.5", "9 0 0.5");
    assert_eq!(
        points("view.pcd", twice.replace("8 1 2", "8 0 1 2")),
        POINTS
    );
}

/// The mesh of a square, from a PLY file with six vertices, this header of its faces, and these rows of them.
fn surface(faces: &str, rows: &str) -> Surface {
    let text = format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n{faces}end_header\n\
         1 1 0\n0 0 0\nnan nan nan\n1 0 0\n0 1 0\n0 0 0\n{rows}"
    );
    read_surface(file("square.ply", text.as_bytes()).path).unwrap()
}

#[test]
fn a_mesh_keeps_the_origin_where_a_face_names_it() {
    let face = "element face 1\nproperty list ushort uint vertex_indices\nproperty list uchar float texcoord\n";
    let square = surface(face, "4.0 1 3 0 4 8 0 0 1 0 1 1 0 1\n");
    assert_eq!(square.points.len(), 4);
    assert_eq!(square.triangles, [[1, 2, 0], [1, 0, 3]]);
    assert_eq!((square.dropped.non_finite, square.dropped.zero), (1, 1));
    let strip = "element tristrips 1\nproperty list int int vertex_indices\n";
    let strips = surface(strip, "8 1 3 4 0 -1 0 4 3\n");
    assert_eq!(strips.triangles, [[1, 2, 3], [3, 2, 0], [0, 3, 2]]);
    assert_eq!(surface("", "").points.len(), 3);
}
