//! Reading and writing PCD: own parsers for the header and for ASCII data, pcd-rs for binary data.

mod header;

use std::io::{Cursor, ErrorKind};

use nalgebra::Point3;
use pcd_rs::{
    DataKind, DynReader, DynRecord, DynWriter, Error, Field, ValueKind, ViewPoint, WriterInit,
};

use super::{Fault, Raw, one_line};
use crate::text::{self, Tokens};
use header::{Data, EXPORT, Header};

/// The points of a whole PCD file, in its order, and their normals where it has them.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let (mut header, data) = Header::parse(bytes)?;
    match header.data {
        Data::Ascii => settle_columns(&mut header, Tokens::new(data).count())?,
        Data::Binary => settle_bytes(&mut header, data.len())?,
        Data::Compressed => {
            let available = uncompressed_size(data)?;
            settle_bytes(&mut header, available)?;
        }
    }
    let axes = places(&header, ["x", "y", "z"]).ok_or_else(|| {
        let names: Vec<_> = header
            .fields
            .iter()
            .map(|field| field.name.as_str())
            .collect();
        Fault::NoCoordinates(format!("[{}]", names.join(", ")))
    })?;
    let normals = places(&header, ["normal_x", "normal_y", "normal_z"]);
    match header.data {
        Data::Ascii => from_text(&header, data, axes, normals),
        Data::Binary | Data::Compressed => from_binary(&header, data, axes, normals),
    }
}

/// Where three numbers stand in a record; `None` where one is missing.
fn places(header: &Header, names: [&str; 3]) -> Option<[usize; 3]> {
    let place = |name: &str| {
        let is_it = |is_called: &dyn Fn(&str) -> bool| {
            let mut fields = header.fields.iter();
            fields.position(|field| field.count == 1 && is_called(&field.name))
        };
        is_it(&|called| called == name)
            .or_else(|| is_it(&|called| called.eq_ignore_ascii_case(name)))
    };
    match names.map(place) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// Determines the columns of ASCII data from the number of words in a line. A COUNT of 0 means no column to some programs
/// and one column to others, and some programs write padding.
fn settle_columns(header: &mut Header, words: usize) -> Result<(), Fault> {
    let columns = |header: &Header| {
        let counts = header.fields.iter().map(|field| field.count);
        counts
            .fold(0, usize::saturating_add)
            .saturating_mul(header.points)
    };
    let mut without_padding = header.clone();
    let padding = without_padding
        .fields
        .iter_mut()
        .filter(|field| field.is_padding());
    padding.for_each(|field| field.count = 0);
    let mut forms = vec![header.clone(), with_zero_as_one(header), without_padding];
    match forms.iter().position(|form| columns(form) == words) {
        Some(fitting) => {
            *header = forms.swap_remove(fitting);
            Ok(())
        }
        None if columns(header) > words => Err(Fault::Truncated(format!(
            "its header announces {} numbers, there are {words}",
            columns(header)
        ))),
        None => Err(Fault::malformed(
            format!(
                "it has {words} numbers, and its header announces {}",
                columns(header)
            ),
            "name all columns in FIELDS, or correct COUNT and POINTS",
        )),
    }
}

/// Determines the number of bytes of a point, and refuses a header that announces more data than the file holds, which
/// pcd-rs would allocate, or index beyond its end.
fn settle_bytes(header: &mut Header, available: usize) -> Result<(), Fault> {
    let needed = |header: &Header| {
        let sizes = header.fields.iter().map(header::Field::bytes);
        sizes
            .fold(0, usize::saturating_add)
            .saturating_mul(header.points)
    };
    if header.fields.iter().any(|field| field.count == 0) {
        let other = with_zero_as_one(header);
        if needed(&other) == available && needed(header) != available {
            *header = other;
        } else if needed(header) != available {
            let reason = format!(
                "it has {available} bytes of points; with a COUNT of 0 as none its header announces {}, as one {}",
                needed(header),
                needed(&other)
            );
            return Err(Fault::malformed(reason, "correct COUNT and POINTS"));
        }
    }
    match needed(header) {
        needed if needed > available => Err(Fault::Truncated(format!(
            "its header announces {needed} bytes of points, there are {available}"
        ))),
        _ => Ok(()),
    }
}

fn with_zero_as_one(header: &Header) -> Header {
    let mut other = header.clone();
    let fields = other.fields.iter_mut();
    fields.for_each(|field| field.count = field.count.max(1));
    other
}

fn from_text(
    header: &Header,
    data: &[u8],
    axes: [usize; 3],
    normals: Option<[usize; 3]>,
) -> Result<Raw, Fault> {
    let mut tokens = Tokens::new(data);
    let mut raw = Raw::with_capacity(header.points, normals.is_some());
    let mut row = vec![0.0; header.fields.len()];
    let is_wanted =
        |at: usize| axes.contains(&at) || normals.is_some_and(|normals| normals.contains(&at));
    for _ in 0..header.points {
        for (at, field) in header
            .fields
            .iter()
            .enumerate()
            .filter(|(_, field)| field.count > 0)
        {
            let token = tokens.nth(field.count - 1);
            let token =
                token.ok_or_else(|| Fault::Truncated("fewer numbers than points".to_owned()))?;
            if is_wanted(at) {
                row[at] = text::number(token).map_err(|reason| {
                    Fault::malformed(reason, "correct it, or export as binary PCD")
                })?;
            }
        }
        raw.push(
            axes.map(|at| row[at]),
            normals.map(|normals| normals.map(|at| row[at])),
        );
    }
    Ok(raw)
}

fn from_binary(
    header: &Header,
    data: &[u8],
    axes: [usize; 3],
    normals: Option<[usize; 3]>,
) -> Result<Raw, Fault> {
    let mut wanted: Vec<usize> = axes
        .into_iter()
        .chain(normals.into_iter().flatten())
        .collect();
    let canonical = header.canonical(&wanted);
    // A record holds what is wanted alone, in the file's order.
    wanted.sort_unstable();
    let rank =
        |places: [usize; 3]| places.map(|place| wanted.partition_point(|&other| other < place));
    let (axes, normals) = (rank(axes), normals.map(rank));
    let mut raw = Raw::with_capacity(header.points, normals.is_some());
    let reader = std::io::Read::chain(canonical.as_bytes(), Cursor::new(data));
    for record in DynReader::from_reader(reader).map_err(fault)? {
        let record = record.map_err(fault)?;
        let missing = || Fault::NoCoordinates(format!("{record:?}"));
        let point = numbers(&record, axes).ok_or_else(missing)?;
        let normal = normals
            .map(|normals| numbers(&record, normals).ok_or_else(missing))
            .transpose()?;
        raw.push(point, normal);
    }
    Ok(raw)
}

/// The numbers at three places of a record.
fn numbers(record: &DynRecord, places: [usize; 3]) -> Option<[f32; 3]> {
    match places.map(|place| record.0.get(place).and_then(number)) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// A binary PCD file of these points, and of one more number each.
pub(super) fn encode(
    points: &[Point3<f32>],
    more: Option<(&str, &[f32])>,
) -> Result<Vec<u8>, Fault> {
    let mut bytes = Cursor::new(Vec::new());
    let names = ["x", "y", "z"]
        .into_iter()
        .chain(more.map(|(name, _)| name));
    let mut writer: DynWriter<_> = WriterInit {
        width: points.len() as u64,
        height: 1,
        viewpoint: ViewPoint::default(),
        data_kind: DataKind::Binary,
        schema: Some(names.map(|name| (name, ValueKind::F32, 1)).collect()),
        version: None,
    }
    .build_from_writer(&mut bytes)
    .map_err(fault)?;
    let record = |index: usize, point: &Point3<f32>| {
        let more = more.and_then(|(_, values)| values.get(index));
        let values = point.iter().chain(more);
        DynRecord(values.map(|&value| Field::F32(vec![value])).collect())
    };
    let pushed = points
        .iter()
        .enumerate()
        .try_for_each(|(index, point)| writer.push(&record(index, point)));
    // The writer panics if it is dropped unfinished, also after an error.
    let finished = writer.finish();
    pushed.and(finished).map_err(fault)?;
    Ok(bytes.into_inner())
}

fn uncompressed_size(data: &[u8]) -> Result<usize, Fault> {
    let word = |at: usize| {
        data.get(at..at + 4)
            .and_then(|word| word.try_into().ok())
            .map(u32::from_le_bytes)
    };
    let (Some(compressed), Some(uncompressed)) = (word(0), word(4)) else {
        return Err(Fault::Truncated(
            "the sizes of its compressed part are missing".to_owned(),
        ));
    };
    let (compressed, uncompressed) = (compressed as usize, uncompressed as usize);
    let available = data.len() - 8;
    if compressed > available {
        return Err(Fault::Truncated(format!(
            "{compressed} compressed bytes announced, there are {available}"
        )));
    }
    // LZF expands three bytes to at most 264.
    if uncompressed > compressed.saturating_mul(88) {
        let reason = format!("{compressed} bytes cannot unpack to {uncompressed}");
        return Err(Fault::malformed(reason, EXPORT));
    }
    // pcd-rs holds the decompressed bytes twice.
    if uncompressed > UNPACKED_MAX.saturating_add(data.len()) {
        let reason = format!("its {compressed} bytes unpack to {uncompressed}");
        return Err(Fault::malformed(
            reason,
            "export it as binary, not binary_compressed",
        ));
    }
    Ok(uncompressed)
}

/// Decompressed points may take this many bytes more than the file: a limit against decompression bombs.
const UNPACKED_MAX: usize = 24 << 20;

fn number(field: &Field) -> Option<f32> {
    match field {
        Field::F32(values) => values.first().copied(),
        Field::F64(values) => values.first().map(|&value| value as f32),
        Field::I8(values) => values.first().map(|&value| f32::from(value)),
        Field::I16(values) => values.first().map(|&value| f32::from(value)),
        Field::I32(values) => values.first().map(|&value| value as f32),
        Field::I64(values) => values.first().map(|&value| value as f32),
        Field::U8(values) => values.first().map(|&value| f32::from(value)),
        Field::U16(values) => values.first().map(|&value| f32::from(value)),
        Field::U32(values) => values.first().map(|&value| value as f32),
        Field::U64(values) => values.first().map(|&value| value as f32),
    }
}

fn fault(error: Error) -> Fault {
    let message = one_line(&error.to_string());
    match error {
        Error::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            Fault::Truncated(message)
        }
        _ => Fault::malformed(message, EXPORT),
    }
}
