//! Depth images compressed by `compressed_depth_image_transport`: a header of twelve bytes, then PNG or RVL.
//!
//! The header (`ConfigHeader` of that package, little-endian) is an int32, unused here, and two float32 a and b. Depths in
//! whole millimetres are stored as they are. A depth z in metres is stored as a / z + b, rounded down; 0 means no depth.

use std::io::Cursor;

use crate::image::DepthImage;
use crate::rvl;

/// Most pixels of an image that is decompressed: twice the largest images of depth cameras. Limits the memory that a
/// damaged header can claim.
const PIXELS_MAX: usize = 1 << 22;
const HEAD_SIZE: usize = 12;
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Why a compressed image cannot be decompressed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CompressedError {
    /// Another encoding or compression.
    #[error(
        "the packed depth image has format {format:?}; 16UC1 and 32FC1 as \"compressedDepth\" of png or rvl can be read: \
         unpack it by `rosrun image_transport republish compressedDepth in:=TOPIC raw out:=TOPIC`, TOPIC without \
         /compressedDepth"
    )]
    Format {
        /// The message's format field.
        format: String,
    },
    /// It breaks the rules of its format.
    #[error("the packed depth image cannot be unpacked ({reason}); record it again")]
    Damaged {
        /// The rule that it breaks.
        reason: String,
    },
}

/// A decompressed image.
#[derive(Debug, Clone, PartialEq)]
pub struct Unpacked {
    width: u32,
    height: u32,
    encoding: &'static str,
    data: Vec<u8>,
}

impl Unpacked {
    /// Unpacks the data of a sensor_msgs/CompressedImage.
    ///
    /// # Errors
    /// [`CompressedError`] where `format` is another one or the data are damaged.
    pub fn new(format: &str, data: &[u8]) -> Result<Self, CompressedError> {
        let other = || CompressedError::Format {
            format: format.to_owned(),
        };
        let (encoding, packing) = format.split_once(';').unwrap_or((format, ""));
        let is_metres = match encoding.trim() {
            "16UC1" | "mono16" => false,
            "32FC1" => true,
            _ => return Err(other()),
        };
        let (head, packed) = data
            .split_at_checked(HEAD_SIZE)
            .ok_or_else(|| damaged("its head is cut short"))?;
        let (width, height, words) = if packed.starts_with(PNG_SIGNATURE) {
            png(packed)?
        } else if packing.contains("rvl") {
            by_rvl(packed)?
        } else {
            return Err(other());
        };
        let data = match is_metres {
            false => words.iter().flat_map(|word| word.to_le_bytes()).collect(),
            true => metres(head, &words),
        };
        Ok(Self {
            width,
            height,
            encoding: if is_metres { "32FC1" } else { "16UC1" },
            data,
        })
    }

    /// The image as the raw topic would have it.
    pub fn image(&self) -> DepthImage<'_> {
        let pixel_size = if self.encoding == "32FC1" { 4 } else { 2 };
        DepthImage {
            width: self.width,
            height: self.height,
            step: self.width * pixel_size,
            encoding: self.encoding,
            is_bigendian: false,
            data: &self.data,
        }
    }
}

/// Converts stored words to depths in metres, as little-endian float32.
fn metres(head: &[u8], words: &[u16]) -> Vec<u8> {
    let [a, b] = [4, 8].map(|at| {
        let bytes = head.get(at..).and_then(|bytes| bytes.first_chunk());
        bytes.map_or(f32::NAN, |&bytes| f32::from_le_bytes(bytes))
    });
    let depth = |&word: &u16| match word {
        0 => f32::NAN,
        _ => a / (f32::from(word) - b),
    };
    words
        .iter()
        .flat_map(|word| depth(word).to_le_bytes())
        .collect()
}

fn png(packed: &[u8]) -> Result<(u32, u32, Vec<u16>), CompressedError> {
    let broken = |error: png::DecodingError| damaged(&error.to_string());
    let mut reader = png::Decoder::new(Cursor::new(packed))
        .read_info()
        .map_err(broken)?;
    let (width, height) = reader.info().size();
    if reader.output_color_type() != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(damaged("its PNG is not of 16 bits and one channel"));
    }
    let pixels = pixels(width, height)?;
    let mut bytes = vec![0; 2 * pixels];
    reader.next_frame(&mut bytes).map_err(broken)?;
    let words = bytes.as_chunks().0.iter();
    Ok((
        width,
        height,
        words.map(|&word| u16::from_be_bytes(word)).collect(),
    ))
}

/// Width and height stand before the words, as int32.
fn by_rvl(packed: &[u8]) -> Result<(u32, u32, Vec<u16>), CompressedError> {
    let (Some((&width, rest)), true) = (packed.split_first_chunk(), packed.len() >= 8) else {
        return Err(damaged("its size is missing"));
    };
    let (height, packed) = rest.split_at(4);
    let width = u32::from_le_bytes(width);
    let height = height
        .first_chunk()
        .map_or(0, |&height| u32::from_le_bytes(height));
    let words = rvl::decode(packed, pixels(width, height)?);
    let words = words.ok_or_else(|| damaged("its words do not make its pixels"))?;
    Ok((width, height, words))
}

fn pixels(width: u32, height: u32) -> Result<usize, CompressedError> {
    let pixels = (width as usize).checked_mul(height as usize);
    pixels
        .filter(|&pixels| pixels <= PIXELS_MAX)
        .ok_or_else(|| damaged(&format!("it says to be {width}×{height} pixels")))
}

fn damaged(reason: &str) -> CompressedError {
    CompressedError::Damaged {
        reason: reason.to_owned(),
    }
}
