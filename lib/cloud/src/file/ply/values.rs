//! Reads the numbers after the header of a PLY file one by one.

use super::super::Fault;
use super::header::{Encoding, Kind};
use crate::text::{self, Tokens};

#[derive(Clone)]
pub(super) enum Values<'a> {
    Text(Tokens<'a>),
    Binary { rest: &'a [u8], is_bigendian: bool },
}

/// A number, as exact as its type.
enum Number {
    Whole(i64),
    Real(f64),
}

impl<'a> Values<'a> {
    pub(super) fn new(bytes: &'a [u8], encoding: Encoding) -> Self {
        match encoding {
            Encoding::Ascii => Self::Text(Tokens::new(bytes)),
            _ => Self::Binary {
                rest: bytes,
                is_bigendian: encoding == Encoding::BigEndian,
            },
        }
    }

    /// A coordinate. A word that is no number is an error; NaN and infinities are accepted.
    pub(super) fn number(&mut self, kind: Kind) -> Result<f32, Fault> {
        if let Self::Text(tokens) = self {
            return text::number(tokens.next().ok_or_else(ended)?).map_err(no_number);
        }
        Ok(match self.binary(kind)? {
            Number::Whole(whole) => whole as f32,
            Number::Real(real) => real as f32,
        })
    }

    /// An index or the length of a list.
    pub(super) fn whole(&mut self, kind: Kind) -> Result<i64, Fault> {
        if let Self::Text(tokens) = self {
            return text::whole(tokens.next().ok_or_else(ended)?).map_err(no_number);
        }
        match self.binary(kind)? {
            Number::Whole(whole) => Ok(whole),
            Number::Real(real) if real.fract() == 0.0 && real.abs() < 1e15 => Ok(real as i64),
            Number::Real(real) => Err(no_number(format!("{real} is no whole number"))),
        }
    }

    /// Skips numbers without checking them.
    pub(super) fn skip(&mut self, kind: Kind, count: usize) -> Result<(), Fault> {
        match self {
            Self::Text(tokens) => match count {
                0 => Ok(()),
                _ => tokens.nth(count - 1).map(|_| ()).ok_or_else(ended),
            },
            Self::Binary { rest, .. } => {
                let size = count.checked_mul(kind.size());
                *rest = size.and_then(|size| rest.get(size..)).ok_or_else(ended)?;
                Ok(())
            }
        }
    }

    /// Whether only white space is left. In a binary file, bytes after the last element are ignored.
    pub(super) fn is_at_end(&self) -> bool {
        match self {
            Self::Text(tokens) => tokens.clone().next().is_none(),
            Self::Binary { rest, .. } => rest.is_empty(),
        }
    }

    fn binary(&mut self, kind: Kind) -> Result<Number, Fault> {
        use Number::{Real, Whole};
        match kind {
            Kind::I8 => Ok(Whole(i8::from_le_bytes(self.take()?).into())),
            Kind::U8 => Ok(Whole(u8::from_le_bytes(self.take()?).into())),
            Kind::I16 => Ok(Whole(i16::from_le_bytes(self.take()?).into())),
            Kind::U16 => Ok(Whole(u16::from_le_bytes(self.take()?).into())),
            Kind::I32 => Ok(Whole(i32::from_le_bytes(self.take()?).into())),
            Kind::U32 => Ok(Whole(u32::from_le_bytes(self.take()?).into())),
            Kind::I64 => Ok(Whole(i64::from_le_bytes(self.take()?))),
            // Beyond 2⁶³ it is neither an index nor a length of anything.
            Kind::U64 => Ok(Real(u64::from_le_bytes(self.take()?) as f64)),
            Kind::F32 => Ok(Real(f32::from_le_bytes(self.take()?).into())),
            Kind::F64 => Ok(Real(f64::from_le_bytes(self.take()?))),
            Kind::Unknown => Err(no_number("its type is unknown".to_owned())),
        }
    }

    /// The next bytes of a binary file, the lowest first.
    fn take<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], Fault> {
        let Self::Binary { rest, is_bigendian } = self else {
            return Err(ended());
        };
        let (&(mut bytes), after) = rest.split_first_chunk().ok_or_else(ended)?;
        *rest = after;
        if *is_bigendian {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

fn ended() -> Fault {
    Fault::Truncated("fewer numbers than its header announces".to_owned())
}

fn no_number(reason: String) -> Fault {
    Fault::malformed(reason, "correct it, or export as binary PLY")
}
