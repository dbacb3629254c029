//! The header of a PCD file, normalised to the form that pcd-rs reads.
//!
//! Some programs leave out lines for which PCL has defaults, write comments in any encoding, repeat names, or declare
//! padding of zero bytes.

use std::collections::HashMap;
use std::fmt::Write;

use super::super::Fault;
use crate::text::{Lines, without_mark, words};

/// A column, or several of one name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    /// Bytes of one number.
    pub size: usize,
    /// I, U or F.
    pub kind: char,
    pub count: usize,
}

impl Field {
    pub(super) fn is_padding(&self) -> bool {
        self.name == "_"
    }

    /// Bytes a point.
    pub(super) fn bytes(&self) -> usize {
        self.size.saturating_mul(self.count)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Data {
    Ascii,
    Binary,
    Compressed,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    pub fields: Vec<Field>,
    pub points: usize,
    pub data: Data,
}

impl Header {
    /// Reads the header; returns what follows it too.
    pub(super) fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), Fault> {
        let mut lines = Lines::new(without_mark(bytes)?);
        let mut entries: HashMap<String, Vec<String>> = HashMap::new();
        while let Some(line) = lines.next() {
            let line = line.split(|&byte| byte == b'#').next().unwrap_or_default();
            let mut words = words(line).into_iter();
            let Some(key) = words.next().map(|key| key.to_ascii_uppercase()) else {
                continue;
            };
            let is_last = key == "DATA";
            entries.insert(key, words.collect());
            if is_last {
                return Ok((Self::from_entries(&entries)?, lines.rest()));
            }
        }
        Err(Fault::Truncated("its header has no DATA".to_owned()))
    }

    fn from_entries(entries: &HashMap<String, Vec<String>>) -> Result<Self, Fault> {
        let names = entries.get("FIELDS").or_else(|| entries.get("COLUMNS"));
        let names = names.ok_or_else(|| Fault::malformed("its header names no FIELDS", EXPORT))?;
        let sizes = column(entries, "SIZE", names.len(), "4")?;
        let kinds = column(entries, "TYPE", names.len(), "F")?;
        let counts = column(entries, "COUNT", names.len(), "1")?;
        let mut fields = Vec::with_capacity(names.len());
        for (at, name) in names.iter().enumerate() {
            fields.push(Field {
                name: name.clone(),
                size: whole("SIZE", sizes[at])?,
                kind: kinds[at].chars().next().unwrap_or('F').to_ascii_uppercase(),
                count: whole("COUNT", counts[at])?,
            });
        }
        let data = entries.get("DATA").and_then(|words| words.first());
        let data = match data.map(|data| data.to_ascii_lowercase()).as_deref() {
            Some("ascii") => Data::Ascii,
            Some("binary") => Data::Binary,
            Some("binary_compressed") => Data::Compressed,
            _ => {
                let reason = format!("its DATA is {:?}", data.map_or("", String::as_str));
                return Err(Fault::malformed(
                    reason,
                    "export it as ascii, binary or binary_compressed",
                ));
            }
        };
        Ok(Self {
            fields,
            points: points(entries)?,
            data,
        })
    }

    /// The same header in pcd-rs's form. Columns that are not `wanted` become padding, whatever they are.
    pub(super) fn canonical(&self, wanted: &[usize]) -> String {
        let fields = self
            .fields
            .iter()
            .enumerate()
            .filter(|(_, field)| field.bytes() > 0);
        let (mut names, mut sizes, mut kinds, mut counts) =
            (String::new(), String::new(), String::new(), String::new());
        for (at, field) in fields {
            let is_wanted = wanted.contains(&at);
            let (name, kind) = if is_wanted {
                (field.name.as_str(), field.kind)
            } else {
                ("_", 'U')
            };
            let (size, count) = if is_wanted {
                (field.size, field.count)
            } else {
                (1, field.bytes())
            };
            // Writing to a string cannot fail.
            let _ = write!(names, " {name}");
            let _ = write!(sizes, " {size}");
            let _ = write!(kinds, " {kind}");
            let _ = write!(counts, " {count}");
        }
        let data = match self.data {
            Data::Ascii => "ascii",
            Data::Binary => "binary",
            Data::Compressed => "binary_compressed",
        };
        format!(
            "VERSION 0.7\nFIELDS{names}\nSIZE{sizes}\nTYPE{kinds}\nCOUNT{counts}\nWIDTH {0}\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA {data}\n",
            self.points
        )
    }
}

pub(super) const EXPORT: &str = "export it again as PCD";

/// The words of a header line that has one for each field. A missing line stands for the default.
fn column<'a>(
    entries: &'a HashMap<String, Vec<String>>,
    key: &str,
    fields: usize,
    default: &'a str,
) -> Result<Vec<&'a str>, Fault> {
    match entries.get(key) {
        None => Ok(vec![default; fields]),
        Some(words) if words.len() == fields => Ok(words.iter().map(String::as_str).collect()),
        Some(words) => Err(Fault::malformed(
            format!(
                "its header has {} words behind {key}, for {fields} FIELDS",
                words.len()
            ),
            "correct its header",
        )),
    }
}

fn whole(key: &str, word: &str) -> Result<usize, Fault> {
    let reason = || Fault::malformed(format!("{word:?} is no {key}"), "correct its header");
    word.parse().map_err(|_| reason())
}

/// POINTS, or what the width and height of an organised cloud make.
fn points(entries: &HashMap<String, Vec<String>>) -> Result<usize, Fault> {
    let entry = |key| {
        let word = entries.get(key).and_then(|words| words.first());
        word.map(|word| whole(key, word)).transpose()
    };
    let (points, width, height) = (entry("POINTS")?, entry("WIDTH")?, entry("HEIGHT")?);
    let cells = width.map(|width| width.saturating_mul(height.unwrap_or(1)));
    points
        .or(cells)
        .ok_or_else(|| Fault::malformed("its header says no number of POINTS", EXPORT))
}
