//! PLY, by ply-rs-bw.

use std::borrow::Cow;
use std::io::{Cursor, ErrorKind};
use std::iter;

use nalgebra::{Point3, Vector3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::{Fault, Raw, one_line};

/// The vertices and faces of a whole PLY file, in its order.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let bytes = &*with_readable_numbers(bytes);
    let mut reader = Reader::new(Cursor::new(bytes));
    let vertices = Parser::<Vertex>::new();
    let faces = Parser::<Face>::new();
    let others = Parser::<Ignored>::new();
    let header = vertices.read_header(&mut reader).map_err(fault)?;
    check(&header, bytes.len())?;

    let mut raw = Raw::default();
    for element in header.elements.values() {
        match element.name.as_str() {
            VERTEX => {
                let read = vertices
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
                raw.points = read.iter().map(Vertex::point).collect();
                raw.normals = NORMAL
                    .into_iter()
                    .all(|axis| is_scalar(element, axis))
                    .then(|| read.iter().map(Vertex::normal).collect());
            }
            FACE => {
                let read = faces
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
                raw.faces = read.into_iter().map(|face| face.0).collect();
            }
            _ => {
                others
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(fault)?;
            }
        }
    }
    Ok(raw)
}

/// A binary little-endian PLY file of these points.
pub(super) fn encode(points: &[Point3<f32>]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement {VERTEX} {}\n\
         property float x\nproperty float y\nproperty float z\nend_header\n",
        points.len()
    )
    .into_bytes();
    bytes.extend(
        points
            .iter()
            .flat_map(|point| point.coords.iter())
            .flat_map(|coordinate| coordinate.to_le_bytes()),
    );
    bytes
}

const VERTEX: &str = "vertex";
const FACE: &str = "face";
const AXES: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

/// Spells `nan` and `inf` in an ASCII payload as a number that overflows, since the parser knows no such words.
fn with_readable_numbers(bytes: &[u8]) -> Cow<'_, [u8]> {
    let Some(header_len) = ascii_header_len(bytes) else {
        return Cow::Borrowed(bytes);
    };
    let (header, payload) = bytes.split_at(header_len);
    if !payload.iter().any(|byte| matches!(byte, b'n' | b'N')) {
        return Cow::Borrowed(bytes);
    }
    let words = payload
        .split_inclusive(u8::is_ascii_whitespace)
        .flat_map(|word| {
            let end = word
                .iter()
                .position(u8::is_ascii_whitespace)
                .unwrap_or(word.len());
            let (text, space) = word.split_at(end);
            let unsigned = text
                .strip_prefix(b"-")
                .or(text.strip_prefix(b"+"))
                .unwrap_or(text);
            let name = unsigned.get(..3).map(<[u8]>::to_ascii_lowercase);
            let is_word = matches!(name.as_deref(), Some(b"nan" | b"inf"));
            [if is_word { b"1e999" } else { text }, space]
        });
    Cow::Owned(iter::once(header).chain(words).flatten().copied().collect())
}

/// Refuses what would read nothing sensible, or would read for ever.
fn check(header: &Header, file_len: usize) -> Result<(), Fault> {
    let Some(vertex) = header.elements.get(VERTEX) else {
        let names: Vec<_> = header.elements.keys().map(String::as_str).collect();
        return Err(Fault::NoCoordinates(format!(
            "elements [{}]",
            names.join(", ")
        )));
    };
    if !AXES.into_iter().all(|axis| is_scalar(vertex, axis)) {
        let names: Vec<_> = vertex.properties.keys().map(String::as_str).collect();
        return Err(Fault::NoCoordinates(format!("[{}]", names.join(", "))));
    }
    let mut needed: usize = 0;
    for element in header.elements.values() {
        needed = needed.saturating_add(
            element
                .count
                .saturating_mul(smallest_size(element, header.encoding)),
        );
    }
    if needed > file_len {
        return Err(Fault::Truncated(format!(
            "its header announces at least {needed} bytes, there are {file_len}"
        )));
    }
    Ok(())
}

fn is_scalar(element: &ElementDef, name: &str) -> bool {
    let property = element.properties.get(name);
    property.is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
}

/// Length of the header if the payload is ASCII.
fn ascii_header_len(bytes: &[u8]) -> Option<usize> {
    let mut len = 0;
    let mut is_ascii = false;
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        len += line.len();
        is_ascii |= line.starts_with(b"format ascii");
        if line.trim_ascii_end() == b"end_header" {
            return is_ascii.then_some(len);
        }
    }
    None
}

/// Bytes that one such element takes at least.
fn smallest_size(element: &ElementDef, encoding: Encoding) -> usize {
    if encoding == Encoding::Ascii {
        return 1;
    }
    let sizes = element
        .properties
        .values()
        .map(|property| match &property.data_type {
            PropertyType::Scalar(kind) | PropertyType::List(kind, _) => size(kind),
        });
    sizes.sum::<usize>().max(1)
}

fn size(kind: &ScalarType) -> usize {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn fault(error: ParseError) -> Fault {
    let message = one_line(&error.to_string());
    match error.kind() {
        ErrorKind::UnexpectedEof => Fault::Truncated(message),
        _ => Fault::Malformed(message),
    }
}

/// A vertex, of which coordinates and normal are kept.
struct Vertex([f32; 6]);

impl Vertex {
    fn point(&self) -> Point3<f32> {
        let [x, y, z, ..] = self.0;
        Point3::new(x, y, z)
    }

    fn normal(&self) -> Vector3<f32> {
        let [.., x, y, z] = self.0;
        Vector3::new(x, y, z)
    }

    fn set(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        let mut names = AXES.into_iter().chain(NORMAL);
        match names.position(|axis| axis == name) {
            Some(axis) => self.0[axis] = value,
            None => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

macro_rules! setters {
    ($($setter:ident: $kind:ty),*) => {
        $(fn $setter(&mut self, name: &str, value: $kind) -> PropertyAccessResult {
            self.set(name, value as f32)
        })*
    };
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 6])
    }

    setters!(set_char: i8, set_uchar: u8, set_short: i16, set_ushort: u16, set_int: i32, set_uint: u32,
             set_float: f32, set_double: f64);
}

/// A face, of which the corners are kept.
struct Face(Vec<i64>);

macro_rules! list_setters {
    ($($setter:ident: $kind:ty),*) => {
        $(fn $setter(&mut self, name: &str, values: Vec<$kind>) -> PropertyAccessResult {
            if !matches!(name, "vertex_indices" | "vertex_index") {
                return PropertyAccessResult::Ignored;
            }
            self.0 = values.into_iter().map(i64::from).collect();
            PropertyAccessResult::Set
        })*
    };
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    list_setters!(set_list_char: i8, set_list_uchar: u8, set_list_short: i16, set_list_ushort: u16,
                  set_list_int: i32, set_list_uint: u32);
}

/// An element that is read over.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}
