//! PCD, by pcd-rs.

use std::io::{Cursor, ErrorKind};

use nalgebra::{Point3, Vector3};
use pcd_rs::{
    DataKind, DynReader, DynRecord, DynWriter, Error, Field, FieldDef, PcdMeta, Schema, ValueKind,
    ViewPoint, WriterInit,
};

use super::{Fault, Raw, one_line};

/// The points of a whole PCD file, in its order, and their normals where it has them.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, Fault> {
    let mut data = bytes;
    let meta = PcdMeta::from_reader(&mut data).map_err(fault)?;
    let fields = fields(&meta);
    let axes = places(&fields, ["x", "y", "z"]).ok_or_else(|| {
        let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
        Fault::NoCoordinates(format!("[{}]", names.join(", ")))
    })?;
    let normal_axes = places(&fields, ["normal_x", "normal_y", "normal_z"]);
    check_size(&meta, data)?;

    let mut points = Vec::new();
    let mut normals = normal_axes.map(|_| Vec::new());
    for record in DynReader::from_reader(Cursor::new(bytes)).map_err(fault)? {
        let record = record.map_err(fault)?;
        let missing = || Fault::NoCoordinates(format!("{record:?}"));
        points.push(numbers(&record, axes).ok_or_else(missing)?.into());
        if let (Some(axes), Some(normals)) = (normal_axes, &mut normals) {
            normals.push(Vector3::from(numbers(&record, axes).ok_or_else(missing)?));
        }
    }
    Ok(Raw {
        points,
        normals,
        faces: Vec::new(),
    })
}

/// The numbers at three places of a record.
fn numbers(record: &DynRecord, places: [usize; 3]) -> Option<[f32; 3]> {
    match places.map(|place| record.0.get(place).and_then(number)) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// A binary PCD file of these points.
pub(super) fn encode(points: &[Point3<f32>]) -> Result<Vec<u8>, Fault> {
    let mut bytes = Cursor::new(Vec::new());
    let axis = |name| (name, ValueKind::F32, 1);
    let mut writer: DynWriter<_> = WriterInit {
        width: points.len() as u64,
        height: 1,
        viewpoint: ViewPoint::default(),
        data_kind: DataKind::Binary,
        schema: Some(Schema::from_iter([axis("x"), axis("y"), axis("z")])),
        version: None,
    }
    .build_from_writer(&mut bytes)
    .map_err(fault)?;
    let record = |point: &Point3<f32>| {
        DynRecord(
            point
                .iter()
                .map(|&coordinate| Field::F32(vec![coordinate]))
                .collect(),
        )
    };
    let pushed = points
        .iter()
        .try_for_each(|point| writer.push(&record(point)));
    // The writer panics if it is dropped unfinished, also after an error.
    let finished = writer.finish();
    pushed.and(finished).map_err(fault)?;
    Ok(bytes.into_inner())
}

/// The fields of a record, which has no padding fields.
fn fields(meta: &PcdMeta) -> Vec<&FieldDef> {
    let fields = meta.field_defs.iter();
    fields.filter(|field| !field.is_padding()).collect()
}

/// Where three numbers stand in a record; `None` where one is missing.
fn places(fields: &[&FieldDef], names: [&str; 3]) -> Option<[usize; 3]> {
    let place = |name: &str| {
        fields
            .iter()
            .position(|field| field.name == name && field.count == 1)
    };
    match names.map(place) {
        [Some(x), Some(y), Some(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// Refuses a header that announces more than the file holds: the reader would allocate it, or index past its end.
fn check_size(meta: &PcdMeta, data: &[u8]) -> Result<(), Fault> {
    let sizes = meta.field_defs.iter().map(|field| match meta.data {
        // A digit and a space.
        DataKind::Ascii => field.count.saturating_mul(2),
        _ => field.count.saturating_mul(field.kind.byte_size() as u64),
    });
    let needed = sizes
        .fold(0, u64::saturating_add)
        .saturating_mul(meta.num_points);
    let (available, slack) = match meta.data {
        // Nothing needs to follow the last digit.
        DataKind::Ascii => (data.len() as u64, 1),
        DataKind::Binary => (data.len() as u64, 0),
        DataKind::BinaryCompressed => (uncompressed_size(data)?, 0),
    };
    if needed > available.saturating_add(slack) {
        return Err(Fault::Truncated(format!(
            "its header announces {needed} bytes of points, there are {available}"
        )));
    }
    Ok(())
}

fn uncompressed_size(data: &[u8]) -> Result<u64, Fault> {
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
    let available = data.len() as u64 - 8;
    if u64::from(compressed) > available {
        return Err(Fault::Truncated(format!(
            "{compressed} compressed bytes announced, there are {available}"
        )));
    }
    // LZF makes at most 264 bytes of three.
    if u64::from(uncompressed) > u64::from(compressed) * 88 {
        return Err(Fault::Malformed(format!(
            "{compressed} bytes cannot unpack to {uncompressed}"
        )));
    }
    Ok(u64::from(uncompressed))
}

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
        Error::TextTokenMismatchError { found: 0, .. } => {
            Fault::Truncated("fewer lines than points".to_owned())
        }
        Error::ParseError { .. } if message.contains("end of file") => Fault::Truncated(message),
        _ => Fault::Malformed(message),
    }
}
