//! The header of a PLY file.

use super::super::Fault;
use crate::text::{Lines, without_mark, words};

/// How the numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    /// An unknown type; in ASCII files such values can be skipped.
    Unknown,
}

impl Kind {
    fn of(name: &str) -> Self {
        match name.to_ascii_lowercase().as_str() {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => Self::Unknown,
        }
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
            Self::Unknown => 0,
        }
    }
}

/// A column of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// Of a list: the type of its length.
    pub length: Option<Kind>,
}

/// An element of PLY, such as `vertex`: `count` records with the same properties.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// Where the scalar of this name stands; if none is called so, one that differs by capitals.
    pub(super) fn scalar(&self, name: &str) -> Option<usize> {
        let place = |is_it: &dyn Fn(&str) -> bool| {
            let mut properties = self.properties.iter();
            properties.position(|property| property.length.is_none() && is_it(&property.name))
        };
        place(&|called| called == name)
            .or_else(|| place(&|called| called.eq_ignore_ascii_case(name)))
    }

    /// Where the list of the corners stands.
    pub(super) fn corners(&self) -> Option<usize> {
        self.properties.iter().position(|property| {
            property.length.is_some()
                && ["vertex_indices", "vertex_index"]
                    .contains(&property.name.to_ascii_lowercase().as_str())
        })
    }

    /// Bytes that one such element takes at least; as text, each number takes a digit and a space.
    pub(super) fn smallest_size(&self, encoding: Encoding) -> usize {
        let sizes = self.properties.iter().map(|property| match encoding {
            Encoding::Ascii => 2,
            _ => property.length.unwrap_or(property.kind).size(),
        });
        sizes.fold(0, usize::saturating_add)
    }
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

impl Header {
    /// Reads the header; returns what follows it too.
    pub(super) fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), Fault> {
        let mut lines = Lines::new(without_mark(bytes)?.trim_ascii_start());
        if !lines
            .next()
            .is_some_and(|line| line.eq_ignore_ascii_case(b"ply"))
        {
            return Err(Fault::malformed("its first line is not \"ply\"", EXPORT));
        }
        let mut encoding = None;
        let mut elements = Vec::new();
        while let Some(line) = lines.next() {
            let words = words(line);
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            match words.as_slice() {
                [] | ["comment" | "obj_info", ..] => {}
                ["end_header"] => {
                    let encoding = encoding
                        .ok_or_else(|| Fault::malformed("its header names no format", EXPORT))?;
                    let header = Self { encoding, elements };
                    header.check()?;
                    return Ok((header, lines.rest()));
                }
                ["format", name, ..] => encoding = Some(self::encoding(name)?),
                ["element", name, count, ..] => elements.push(element(name, count)?),
                ["property", words @ ..] => {
                    let property =
                        property(words).ok_or_else(|| not_understood(&lines, &words.join(" ")))?;
                    let element = elements.last_mut();
                    element
                        .ok_or_else(|| not_understood(&lines, "property"))?
                        .properties
                        .push(property);
                }
                _ => return Err(not_understood(&lines, &words.join(" "))),
            }
        }
        Err(Fault::Truncated("its header has no end_header".to_owned()))
    }

    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.is_called(name))
    }

    /// A binary file can only be read past numbers whose size is known.
    fn check(&self) -> Result<(), Fault> {
        for (at, element) in self.elements.iter().enumerate() {
            if self.elements[..at]
                .iter()
                .any(|other| other.is_called(&element.name))
            {
                let reason = format!("its header has two elements {:?}", element.name);
                return Err(Fault::malformed(reason, "export each to a file of its own"));
            }
            let mut properties = element.properties.iter();
            let unknown = properties.find(|property| {
                let is_unknown = |kind| kind == Kind::Unknown;
                self.encoding != Encoding::Ascii
                    && (is_unknown(property.kind) || property.length.is_some_and(is_unknown))
            });
            if let Some(Property { name, .. }) = unknown {
                let reason =
                    format!("its property {name:?} is of a type that the format does not know");
                return Err(Fault::malformed(
                    reason,
                    "export it again without this property, or as text",
                ));
            }
        }
        Ok(())
    }
}

impl Element {
    pub(super) fn is_called(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
    }
}

pub(super) const EXPORT: &str = "export it again as PLY";

fn not_understood(lines: &Lines, line: &str) -> Fault {
    let line: String = line.chars().take(60).collect();
    let reason = format!(
        "line {} of its header, {line:?}, is none of the format's",
        lines.taken()
    );
    Fault::malformed(reason, "delete it, or put \"comment\" before it")
}

fn encoding(name: &str) -> Result<Encoding, Fault> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(Fault::malformed(
            format!("its format {name:?} is unknown"),
            "export it as ascii, binary_little_endian or binary_big_endian",
        )),
    }
}

fn element(name: &str, count: &str) -> Result<Element, Fault> {
    let count = count.parse().map_err(|_| {
        Fault::malformed(
            format!("{count:?} is no number of elements {name:?}"),
            EXPORT,
        )
    })?;
    Ok(Element {
        name: name.to_owned(),
        count,
        properties: Vec::new(),
    })
}

/// A name may hold spaces: it goes to the end of the line.
fn property(words: &[&str]) -> Option<Property> {
    let (length, kind, name) = match words {
        ["list", length, kind, name @ ..] => (Some(Kind::of(length)), kind, name),
        [kind, name @ ..] => (None, kind, name),
        [] => return None,
    };
    (!name.is_empty()).then(|| Property {
        name: name.join(" "),
        kind: Kind::of(kind),
        length,
    })
}
