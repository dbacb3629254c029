//! Sizes of a message on the wire, checked before anything is allocated for it.
//!
//! rosrust believes each array length that arrives and allocates it unchecked: 28 bytes of a forged `JointState` abort the
//! process. A [`Layout`] is made of the message's own definition text and walks the bytes first.

#[cfg(test)]
mod example;
mod parse;

use std::io;

/// Size of the largest message that is accepted, in bytes; an uncompressed 848 × 480 cloud has 13 MB.
pub const MESSAGE_BYTES_MAX: usize = 64 << 20;

/// Elements of arrays whose elements differ in size, in one message, at most. They are larger in memory than on the wire: an
/// empty string takes 4 bytes there and 24 here.
pub const ELEMENTS_MAX: usize = 1 << 16;

/// The wire format of a message: what follows what, and which lengths are read from the wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout(Vec<Item>);

#[derive(Debug, Clone, PartialEq)]
enum Item {
    /// A number of bytes that may have any values.
    Fixed(usize),
    /// A number of `bool`s of one byte each, 0 or 1. rosrust would transmute other bytes to `bool`, which is undefined
    /// behaviour.
    Truth(usize),
    /// An array whose length precedes it; a string is one of 1-byte elements.
    Array(Layout),
}

impl Layout {
    /// Checks that `bytes` start with a valid serialised message of this layout. Also sets each `bool` in it to 0 or 1, since another value
    /// would be undefined behaviour in Rust.
    ///
    /// # Errors
    /// The bytes end before the message does, or a length in it exceeds its limit.
    pub fn check(&self, bytes: &mut [u8]) -> io::Result<()> {
        let mut walk = Walk {
            rest: bytes,
            elements: 0,
        };
        walk.message(self)
    }
}

/// What has not been looked at yet, and how many elements were.
struct Walk<'a> {
    rest: &'a mut [u8],
    elements: usize,
}

impl<'a> Walk<'a> {
    fn message(&mut self, layout: &Layout) -> io::Result<()> {
        for item in &layout.0 {
            match item {
                Item::Fixed(size) => self.take(*size).map(drop)?,
                Item::Truth(count) => self.take_truth(*count)?,
                Item::Array(element) => self.array(element)?,
            }
        }
        Ok(())
    }

    fn array(&mut self, element: &Layout) -> io::Result<()> {
        let length = self.take(4)?;
        let count = length
            .first_chunk()
            .map_or(0, |four| u32::from_le_bytes(*four)) as usize;
        match element.0[..] {
            [] => Ok(()),
            [Item::Fixed(size)] => self.take(count.saturating_mul(size)).map(drop),
            [Item::Truth(each)] => self.take_truth(count.saturating_mul(each)),
            _ => {
                self.elements = self.elements.saturating_add(count);
                check_elements(self.elements)?;
                (0..count).try_for_each(|_| self.message(element))
            }
        }
    }

    /// Any byte but 0 is true, as in C++ and Python.
    fn take_truth(&mut self, count: usize) -> io::Result<()> {
        for byte in self.take(count)? {
            *byte = u8::from(*byte != 0);
        }
        Ok(())
    }

    fn take(&mut self, size: usize) -> io::Result<&'a mut [u8]> {
        let left = self.rest.len();
        let Some((taken, rest)) = std::mem::take(&mut self.rest).split_at_mut_checked(size) else {
            let text = format!("message claims {size} more bytes where {left} are left");
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, text));
        };
        self.rest = rest;
        Ok(taken)
    }
}

fn check_elements(elements: usize) -> io::Result<()> {
    if elements <= ELEMENTS_MAX {
        return Ok(());
    }
    let text = format!("message claims {elements} elements; the limit is {ELEMENTS_MAX}");
    Err(io::Error::new(io::ErrorKind::InvalidData, text))
}

#[cfg(test)]
mod tests;
