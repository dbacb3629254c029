//! Depth images as they come in messages (REP 118).

/// A sensor_msgs/Image, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct DepthImage<'a> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bytes from one row to the next.
    pub step: u32,
    /// `16UC1`, which some drivers and bridges call `mono16` (mm, 0 invalid), or `32FC1` (m, not finite or not positive
    /// invalid).
    pub encoding: &'a str,
    /// Whether the high byte comes first.
    pub is_bigendian: bool,
    /// `step` × `height` bytes.
    pub data: &'a [u8],
}

impl<'a> DepthImage<'a> {
    /// An image in whole millimetres, little-endian, without padding: `data` has two bytes for each pixel.
    pub fn of_millimetres(width: u32, height: u32, data: &'a [u8]) -> Self {
        Self {
            width,
            height,
            step: 2 * width,
            encoding: "16UC1",
            is_bigendian: false,
            data,
        }
    }
}

/// Why an image cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// An encoding that holds no depths.
    #[error(
        "the depth image has encoding {encoding:?}; only 16UC1 or mono16 (mm) and 32FC1 (m) hold depths: \
         connect the camera's depth topic"
    )]
    Encoding {
        /// The message's encoding.
        encoding: String,
    },
    /// `step` is smaller than a row, so that rows would overlap.
    #[error(
        "the depth image has step {step}, but {width} pixels of {encoding} take {needed} bytes a row; \
         correct the program that publishes it"
    )]
    Step {
        /// Bytes from row to row.
        step: u32,
        /// Columns.
        width: u32,
        /// The message's encoding.
        encoding: String,
        /// Number of bytes that a row needs.
        needed: u64,
    },
    /// The data's length is not `step` × `height`.
    #[error(
        "the depth image has {len} bytes of data, but {height} rows of {step} bytes are {expected}; \
         correct the program that publishes it"
    )]
    DataLength {
        /// Length of the data, bytes.
        len: usize,
        /// Rows.
        height: u32,
        /// Bytes from row to row.
        step: u32,
        /// Expected length, bytes.
        expected: u64,
    },
    /// No rows or no columns.
    #[error("the depth image is {width}×{height} pixels, which is no image")]
    Empty {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}

/// An image's depths in its own unit, row by row; 0 is invalid.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Depths {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f32>,
    /// How many units are a metre.
    pub(crate) units_per_m: f32,
    /// Whether depths are whole units.
    pub(crate) is_whole: bool,
}

impl Depths {
    pub(crate) fn row(&self, y: usize) -> &[f32] {
        &self.values[y * self.width..][..self.width]
    }
}

impl DepthImage<'_> {
    /// Checks the image and writes its depths into `depths`, whose memory is reused.
    pub(crate) fn decode(&self, depths: &mut Depths) -> Result<(), ImageError> {
        let pixel_size = self.check()?;
        let row_size = self.width as usize * pixel_size;
        let rows = self
            .data
            .chunks_exact(self.step as usize)
            .map(|row| &row[..row_size]);
        depths.width = self.width as usize;
        depths.height = self.height as usize;
        depths.is_whole = pixel_size == 2;
        depths.units_per_m = if depths.is_whole { 1000.0 } else { 1.0 };
        depths.values.clear();
        depths.values.reserve(depths.width * depths.height);
        for row in rows {
            match (depths.is_whole, self.is_bigendian) {
                (true, false) => depths
                    .values
                    .extend(words(row).map(|&word| f32::from(u16::from_le_bytes(word)))),
                (true, true) => depths
                    .values
                    .extend(words(row).map(|&word| f32::from(u16::from_be_bytes(word)))),
                (false, false) => depths
                    .values
                    .extend(words(row).map(|&word| valid(f32::from_le_bytes(word)))),
                (false, true) => depths
                    .values
                    .extend(words(row).map(|&word| valid(f32::from_be_bytes(word)))),
            }
        }
        Ok(())
    }

    /// Returns the bytes a pixel.
    fn check(&self) -> Result<usize, ImageError> {
        let &Self {
            width,
            height,
            step,
            ..
        } = self;
        let encoding = self.encoding.to_owned();
        let pixel_size: usize = match self.encoding {
            "16UC1" | "mono16" => 2,
            "32FC1" => 4,
            _ => return Err(ImageError::Encoding { encoding }),
        };
        if width == 0 || height == 0 {
            return Err(ImageError::Empty { width, height });
        }
        let needed = u64::from(width) * pixel_size as u64;
        if u64::from(step) < needed {
            return Err(ImageError::Step {
                step,
                width,
                encoding,
                needed,
            });
        }
        let expected = u64::from(step) * u64::from(height);
        if self.data.len() as u64 != expected {
            return Err(ImageError::DataLength {
                len: self.data.len(),
                height,
                step,
                expected,
            });
        }
        Ok(pixel_size)
    }
}

fn words<const SIZE: usize>(row: &[u8]) -> impl Iterator<Item = &[u8; SIZE]> {
    row.as_chunks().0.iter()
}

/// Maps REP 117's non-depths to 0: infinities mean too near or too far, NaN means unknown.
fn valid(depth_m: f32) -> f32 {
    if depth_m.is_finite() && depth_m > 0.0 {
        depth_m
    } else {
        0.0
    }
}
