//! A direction along an axis, as users write it.

use std::fmt::{self, Display};
use std::str::FromStr;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// `+x`, `-x`, `+y`, `-y`, `+z` or `-z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Axis {
    /// 0 for x, 1 for y, 2 for z.
    index: usize,
    is_negative: bool,
}

/// Something else.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no axis; write one of +x, -x, +y, -y, +z, -z")]
pub struct AxisError(String);

const LETTERS: [char; 3] = ['x', 'y', 'z'];

impl Axis {
    /// -y: up for a camera that is level, in its optical frame (y down).
    pub const OPTICAL_UP: Self = Self {
        index: 1,
        is_negative: true,
    };

    /// The unit vector.
    pub fn vector(self) -> Vector3<f64> {
        Vector3::ith(self.index, if self.is_negative { -1.0 } else { 1.0 })
    }
}

impl FromStr for Axis {
    type Err = AxisError;

    fn from_str(text: &str) -> Result<Self, AxisError> {
        let error = || AxisError(text.to_owned());
        let (is_negative, letter) = match text.strip_prefix('-') {
            Some(letter) => (true, letter),
            None => (false, text.strip_prefix('+').ok_or_else(error)?),
        };
        let index = LETTERS
            .iter()
            .position(|known| letter.chars().eq([*known]))
            .ok_or_else(error)?;
        Ok(Self { index, is_negative })
    }
}

impl TryFrom<String> for Axis {
    type Error = AxisError;

    fn try_from(text: String) -> Result<Self, AxisError> {
        text.parse()
    }
}

impl From<Axis> for String {
    fn from(axis: Axis) -> Self {
        axis.to_string()
    }
}

impl Display for Axis {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let sign = if self.is_negative { '-' } else { '+' };
        write!(formatter, "{sign}{}", LETTERS[self.index])
    }
}
