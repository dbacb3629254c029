//! The file of kept features: what a model knows of its classes, without their clouds.
//!
//! A line with name and version, a line of JSON, and then for each block two lists of F float32 (the least and the largest
//! value of each feature) and its rows of F bytes, each from 0 (least) to 255 (largest). Little-endian.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// First line of a file.
const VERSION: &str = "deformable_cobot features 1";
/// Largest number of clouds of each label that are kept: for fitting the layers, and for calibration.
pub const KEPT_MAX: [usize; 2] = [480, 160];
/// Strangers are of many kinds: so many times as many of them are looked at and kept.
pub const STRANGERS: usize = 3;
/// No sensible file is larger.
const COUNT_MAX: usize = 10_000_000;

/// Features of M clouds, F of each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FeatureRows {
    width: usize,
    values: Vec<f32>,
}

impl FeatureRows {
    /// None yet; F is `width`.
    pub fn new(width: usize) -> Self {
        Self {
            width,
            values: Vec::new(),
        }
    }

    /// Adds the features of clouds, one after the other.
    ///
    /// # Panics
    /// If they are not F each.
    pub fn push(&mut self, features: &[f32]) {
        assert!(
            self.width > 0 && features.len().is_multiple_of(self.width),
            "{} features are not {} each",
            features.len(),
            self.width
        );
        self.values.extend(features);
    }

    /// Number of clouds, M.
    pub fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Whether there is no cloud.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// F.
    pub fn width(&self) -> usize {
        self.width
    }

    /// As a matrix `[M, F]`.
    pub fn matrix(&self) -> DMatrix<f64> {
        let values = self.values.iter().map(|&value| f64::from(value));
        DMatrix::from_row_iterator(self.len(), self.width, values)
    }

    /// The features of each cloud.
    pub fn rows(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.width.max(1))
    }

    /// Parts of `size` clouds; the last one may have fewer.
    pub fn parts(&self, size: usize) -> impl Iterator<Item = Self> {
        let values = self.values.chunks((size * self.width).max(1));
        values.map(|values| Self {
            width: self.width,
            values: values.to_vec(),
        })
    }

    /// At most `count` of them, evenly chosen.
    pub fn thinned(&self, count: usize) -> Self {
        let all = self.len();
        if all <= count {
            return self.clone();
        }
        let mut thinned = Self::new(self.width);
        let rows: Vec<&[f32]> = self.rows().collect();
        (0..count).for_each(|k| thinned.push(rows[k * all / count]));
        thinned
    }
}

/// Features of one label, or of strangers.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// The label; `None` for what is none of the classes.
    pub label: Option<String>,
    /// To fit the layers with.
    pub fit: FeatureRows,
    /// Of other specimens, to fit the temperature and the threshold of the known score to.
    pub check: FeatureRows,
}

/// The features that were kept of what a model knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// SHA-256 of the model file that they belong to.
    pub model: String,
    /// How they were made, in words.
    pub made: String,
    /// F, features of a cloud.
    pub width: usize,
    /// Of each label in the order of the model, and of strangers last.
    pub blocks: Vec<Block>,
}

/// Why a file of features cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KeptError {
    /// It is something else.
    #[error(
        "it is no file of features as this version writes it (its first line is not {VERSION:?})"
    )]
    Version,
    /// It ends early, or says what cannot be.
    #[error("it is damaged: {0}")]
    Damaged(String),
}

#[derive(Serialize, Deserialize)]
struct Header {
    model: String,
    made: String,
    width: usize,
    blocks: Vec<BlockHeader>,
}

#[derive(Serialize, Deserialize)]
struct BlockHeader {
    label: Option<String>,
    fit: usize,
    check: usize,
}

impl Kept {
    /// The block of a label.
    pub fn of(&self, label: &str) -> Option<&Block> {
        let mut blocks = self.blocks.iter();
        blocks.find(|block| block.label.as_deref() == Some(label))
    }

    /// The block of strangers.
    pub fn strangers(&self) -> Option<&Block> {
        self.blocks.iter().find(|block| block.label.is_none())
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// The header cannot be written as JSON.
    pub fn encode(&self) -> Result<Vec<u8>, serde_json::Error> {
        let header = Header {
            model: self.model.clone(),
            made: self.made.clone(),
            width: self.width,
            blocks: self.blocks.iter().map(BlockHeader::of).collect(),
        };
        let mut bytes = format!("{VERSION}\n{}\n", serde_json::to_string(&header)?).into_bytes();
        for block in &self.blocks {
            let ranges = ranges(block, self.width);
            bytes.extend(ranges.iter().flat_map(|range| range[0].to_le_bytes()));
            bytes.extend(ranges.iter().flat_map(|range| range[1].to_le_bytes()));
            for row in block.fit.rows().chain(block.check.rows()) {
                bytes.extend(row.iter().zip(&ranges).map(|(&value, &[least, largest])| {
                    let share = (value - least) / (largest - least).max(f32::MIN_POSITIVE);
                    (255.0 * share).round() as u8
                }));
            }
        }
        Ok(bytes)
    }

    /// Reads the bytes of a file; each feature comes back to within 1/510 of its range.
    ///
    /// # Errors
    /// They are no such file, or it is damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, KeptError> {
        let mut lines = bytes.splitn(3, |&byte| byte == b'\n');
        if lines.next() != Some(VERSION.as_bytes()) {
            return Err(KeptError::Version);
        }
        let damaged = |reason: &str| KeptError::Damaged(reason.to_owned());
        let header = lines.next().unwrap_or_default();
        let header: Header =
            serde_json::from_slice(header).map_err(|error| damaged(&error.to_string()))?;
        let mut reader = Reader(lines.next().unwrap_or_default());
        let count = |block: &BlockHeader| block.fit.saturating_add(block.check);
        if header.width == 0 || header.blocks.iter().any(|b| count(b) > COUNT_MAX) {
            return Err(damaged("it has impossible sizes"));
        }
        let blocks = header.blocks.into_iter();
        let blocks = blocks.map(|block| reader.block(block, header.width));
        let blocks = blocks.collect::<Option<Vec<_>>>();
        let blocks =
            blocks.ok_or_else(|| damaged("it ends early, or has numbers that are none"))?;
        if !reader.0.is_empty() {
            return Err(damaged("it is longer than it says"));
        }
        Ok(Self {
            model: header.model,
            made: header.made,
            width: header.width,
            blocks,
        })
    }
}

impl BlockHeader {
    fn of(block: &Block) -> Self {
        Self {
            label: block.label.clone(),
            fit: block.fit.len(),
            check: block.check.len(),
        }
    }
}

/// Least and largest value of each feature; 0 without clouds.
fn ranges(block: &Block, width: usize) -> Vec<[f32; 2]> {
    let mut ranges = vec![[f32::INFINITY, f32::NEG_INFINITY]; width];
    for row in block.fit.rows().chain(block.check.rows()) {
        for (range, &value) in ranges.iter_mut().zip(row) {
            *range = [range[0].min(value), range[1].max(value)];
        }
    }
    let or_zero = |range: [f32; 2]| {
        if range[0] <= range[1] {
            range
        } else {
            [0.0; 2]
        }
    };
    ranges.into_iter().map(or_zero).collect()
}

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn floats(&mut self, count: usize) -> Option<Vec<f32>> {
        let bytes = self.take(count.checked_mul(size_of::<f32>())?)?;
        let values = bytes.chunks_exact(4);
        let values: Vec<f32> = values
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        values
            .iter()
            .all(|value| value.is_finite())
            .then_some(values)
    }

    fn block(&mut self, header: BlockHeader, width: usize) -> Option<Block> {
        let (least, largest) = (self.floats(width)?, self.floats(width)?);
        let mut rows = |count: usize| {
            let bytes = self.take(count.checked_mul(width)?)?;
            let mut rows = FeatureRows::new(width);
            for row in bytes.chunks_exact(width) {
                let ranges = least.iter().zip(&largest);
                let value = |(&byte, (least, largest)): (&u8, (&f32, &f32))| {
                    least + f32::from(byte) / 255.0 * (largest - least)
                };
                rows.values.extend(row.iter().zip(ranges).map(value));
            }
            Some(rows)
        };
        Some(Block {
            fit: rows(header.fit)?,
            check: rows(header.check)?,
            label: header.label,
        })
    }
}

#[cfg(test)]
mod tests;
