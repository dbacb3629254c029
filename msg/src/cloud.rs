//! `sensor_msgs/PointCloud2` to and from points.
//!
//! What is written has the layout of realsense2_camera's cloud without texture: x, y, z as little-endian float32 at the
//! offsets 0, 4 and 8, `point_step` 16, unordered. What is read may carry the three fields at any offset and in any order.

use nalgebra::Point3;
use rosrust_msg::sensor_msgs::{PointCloud2, PointField};
use rosrust_msg::std_msgs::Header;
use thiserror::Error;

/// Bytes from one written point to the next: three floats and the padding that realsense2_camera leaves.
const POINT_STEP: usize = 16;

/// Why a cloud message cannot be read.
#[derive(Debug, Error, PartialEq)]
pub enum CloudError {
    /// A coordinate is missing.
    #[error("the cloud has no field '{0}' (it has: {1}); publish x, y and z as FLOAT32")]
    MissingField(&'static str, String),
    /// A coordinate is stored as something else than one float32.
    #[error(
        "field '{0}' of the cloud has datatype {1} and count {2}; FLOAT32 (7) and 1 are needed"
    )]
    FieldType(&'static str, u8, u32),
    /// A coordinate would lie outside its point.
    #[error(
        "field '{field}' at offset {offset} does not fit into a point_step of {point_step} bytes"
    )]
    FieldOffset {
        /// Name of the coordinate.
        field: &'static str,
        /// Its declared offset in bytes.
        offset: u32,
        /// The declared size of a point in bytes.
        point_step: u32,
    },
    /// Width, height and steps disagree with the data.
    #[error(
        "a cloud of {width} x {height} points, {point_step} bytes each and {row_step} a row, does not fit {len} bytes of data"
    )]
    Size {
        /// Points in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes of a point.
        point_step: u32,
        /// Bytes of a row.
        row_step: u32,
        /// Bytes there are.
        len: usize,
    },
    /// The data is big-endian.
    #[error("the cloud is big-endian; publish it little-endian")]
    BigEndian,
}

/// The points of a message and how many of its entries were none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decoded {
    /// Metres, in the frame of the message's header.
    pub points: Vec<Point3<f32>>,
    /// Entries that were not finite or (0, 0, 0), which ordered RealSense clouds use for "nothing seen".
    pub invalid: usize,
}

/// Reads the points of `message`, in order.
///
/// # Errors
/// [`CloudError`]: the message is big-endian, has no float32 x, y, z, or its sizes do not fit.
pub fn to_points(message: &PointCloud2) -> Result<Decoded, CloudError> {
    let mut decoded = Decoded::default();
    // By what there is, not by what is announced, which has not been checked yet.
    decoded
        .points
        .reserve(message.data.len() / message.point_step.max(12) as usize);
    each(message, ["x", "y", "z"], |[x, y, z]| {
        if is_measured([x, y, z]) {
            decoded.points.push(Point3::new(x, y, z));
        } else {
            decoded.invalid += 1;
        }
    })?;
    Ok(decoded)
}

/// Reads one more field of the points that [`to_points`] gives, in the same order.
///
/// # Errors
/// [`CloudError`]: the message is big-endian, has no such float32 field, or its sizes do not fit.
pub fn values(message: &PointCloud2, name: &'static str) -> Result<Vec<f32>, CloudError> {
    let mut values = Vec::new();
    each(message, ["x", "y", "z", name], |[x, y, z, value]| {
        if is_measured([x, y, z]) {
            values.push(value);
        }
    })?;
    Ok(values)
}

fn is_measured(point: [f32; 3]) -> bool {
    point.iter().all(|value| value.is_finite()) && point != [0.0; 3]
}

/// Hands on these fields of every entry.
fn each<const N: usize>(
    message: &PointCloud2,
    names: [&'static str; N],
    mut take: impl FnMut([f32; N]),
) -> Result<(), CloudError> {
    if message.is_bigendian {
        return Err(CloudError::BigEndian);
    }
    let mut offsets = [0; N];
    for (offset, name) in offsets.iter_mut().zip(names) {
        *offset = field_offset(message, name)?;
    }
    check_size(message)?;
    let (width, step) = (message.width as usize, message.point_step as usize);
    // A cloud without points may say that its rows have no bytes.
    for row in message
        .data
        .chunks(message.row_step.max(1) as usize)
        .take(message.height as usize)
    {
        for entry in row.chunks_exact(step).take(width) {
            take(offsets.map(|offset| float_at(entry, offset)));
        }
    }
    Ok(())
}

/// A message of `points`, metres in the frame of `header`.
pub fn from_points(header: Header, points: &[Point3<f32>]) -> PointCloud2 {
    let mut data = vec![0; points.len() * POINT_STEP];
    for (entry, point) in data.chunks_exact_mut(POINT_STEP).zip(points) {
        for (bytes, value) in entry.chunks_exact_mut(4).zip(point.iter()) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }
    PointCloud2 {
        header,
        height: 1,
        width: points.len() as u32,
        fields: ["x", "y", "z"]
            .iter()
            .zip([0, 4, 8])
            .map(|(name, offset)| float_field(name, offset))
            .collect(),
        is_bigendian: false,
        point_step: POINT_STEP as u32,
        row_step: data.len() as u32,
        data,
        is_dense: true,
    }
}

/// The same with one more value for each point, as float32 in the place of the padding.
///
/// # Panics
/// There are not as many values as points.
pub fn with_field(
    header: Header,
    points: &[Point3<f32>],
    name: &str,
    values: &[f32],
) -> PointCloud2 {
    assert_eq!(points.len(), values.len());
    let mut cloud = from_points(header, points);
    for (entry, value) in cloud.data.chunks_exact_mut(POINT_STEP).zip(values) {
        entry[12..].copy_from_slice(&value.to_le_bytes());
    }
    cloud.fields.push(float_field(name, 12));
    cloud
}

fn float_field(name: &str, offset: u32) -> PointField {
    PointField {
        name: name.into(),
        offset,
        datatype: PointField::FLOAT32,
        count: 1,
    }
}

fn float_at(entry: &[u8], offset: usize) -> f32 {
    let mut bytes = [0; 4];
    bytes.copy_from_slice(&entry[offset..offset + 4]);
    f32::from_le_bytes(bytes)
}

fn field_offset(message: &PointCloud2, name: &'static str) -> Result<usize, CloudError> {
    let field = message
        .fields
        .iter()
        .find(|field| field.name == name)
        .ok_or_else(|| {
            let names: Vec<_> = message
                .fields
                .iter()
                .map(|field| field.name.as_str())
                .collect();
            CloudError::MissingField(name, names.join(", "))
        })?;
    // Some publishers leave the count of a single value at 0.
    if field.datatype != PointField::FLOAT32 || field.count > 1 {
        return Err(CloudError::FieldType(name, field.datatype, field.count));
    }
    if u64::from(field.offset) + 4 > u64::from(message.point_step) {
        return Err(CloudError::FieldOffset {
            field: name,
            offset: field.offset,
            point_step: message.point_step,
        });
    }
    Ok(field.offset as usize)
}

fn check_size(message: &PointCloud2) -> Result<(), CloudError> {
    let PointCloud2 {
        width,
        height,
        point_step,
        row_step,
        ..
    } = *message;
    let row_bytes = u64::from(width) * u64::from(point_step);
    let all_bytes = u64::from(height) * u64::from(row_step);
    if row_bytes > u64::from(row_step) || all_bytes > message.data.len() as u64 {
        return Err(CloudError::Size {
            width,
            height,
            point_step,
            row_step,
            len: message.data.len(),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
