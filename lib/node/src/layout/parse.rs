//! Layouts made of the text of message definitions: <https://wiki.ros.org/msg>.

use super::{Item, Layout};
use std::collections::HashMap;
use thiserror::Error;

/// Largest depth of nested messages; the definitions in use need 4.
const DEPTH_MAX: usize = 16;

/// Why a definition text cannot be parsed.
#[derive(Debug, Error, PartialEq)]
pub enum LayoutError {
    /// A line is no field, constant or comment.
    #[error("cannot read the line '{0}' of a message definition")]
    Line(String),
    /// A field's type is not defined in the text.
    #[error("message definition names the type '{0}' without defining it")]
    UnknownType(String),
    /// Types contain each other.
    #[error("the message type '{0}' contains itself")]
    Recursive(String),
}

impl Layout {
    /// Parses a definition with the messages that it uses, as connection headers carry it.
    ///
    /// # Errors
    /// [`LayoutError`]: the definition is malformed, or lacks a message that it uses.
    pub fn parse(definition: &str) -> Result<Self, LayoutError> {
        let separator = "=".repeat(80);
        let mut sections = definition.split(&separator);
        let own = sections.next().unwrap_or_default();
        let mut types = HashMap::new();
        for section in sections {
            let section = section.trim_start();
            let (head, body) = section.split_once('\n').unwrap_or((section, ""));
            if let Some(name) = head.strip_prefix("MSG:") {
                types.insert(name.trim(), body);
            }
        }
        Types(types).message(own, "", 0)
    }

    /// Appends `item`, joined with the last one where both have fixed sizes.
    fn push(&mut self, item: Item) {
        match (self.0.last_mut(), item) {
            (Some(Item::Fixed(last)), Item::Fixed(size)) => *last += size,
            (Some(Item::Truth(last)), Item::Truth(count)) => *last += count,
            (_, item) => self.0.push(item),
        }
    }
}

/// Texts of the messages that a definition uses, by their names.
struct Types<'a>(HashMap<&'a str, &'a str>);

impl<'a> Types<'a> {
    fn message(&self, text: &str, package: &str, depth: usize) -> Result<Layout, LayoutError> {
        let mut layout = Layout(Vec::new());
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() || line.contains('=') {
                continue; // nothing, or a constant, which is not sent
            }
            let kind = match line.split_whitespace().collect::<Vec<_>>()[..] {
                [kind, _name] => kind,
                _ => return Err(LayoutError::Line(line.into())),
            };
            let (kind, count) = split_array(kind).ok_or_else(|| LayoutError::Line(line.into()))?;
            let element = self.layout_of(kind, package, depth)?;
            match count {
                Count::One => element.0.into_iter().for_each(|item| layout.push(item)),
                Count::Exactly(count) => {
                    for _ in 0..count {
                        element.0.iter().cloned().for_each(|item| layout.push(item));
                    }
                }
                Count::Sent => layout.push(Item::Array(element)),
            }
        }
        Ok(layout)
    }

    fn layout_of(&self, kind: &str, package: &str, depth: usize) -> Result<Layout, LayoutError> {
        let size = match kind {
            "bool" => return Ok(Layout(vec![Item::Truth(1)])),
            "int8" | "uint8" | "byte" | "char" => 1,
            "int16" | "uint16" => 2,
            "int32" | "uint32" | "float32" => 4,
            "int64" | "uint64" | "float64" | "time" | "duration" => 8,
            "string" => return Ok(Layout(vec![Item::Array(Layout(vec![Item::Fixed(1)]))])),
            _ => {
                if depth == DEPTH_MAX {
                    return Err(LayoutError::Recursive(kind.into()));
                }
                let found = self.find(kind, package);
                let (name, text) = found.ok_or_else(|| LayoutError::UnknownType(kind.into()))?;
                let package = name.split('/').next().unwrap_or_default();
                return self.message(text, package, depth + 1);
            }
        };
        Ok(Layout(vec![Item::Fixed(size)]))
    }

    /// Finds `kind` by its full name, in the package of the message that uses it, or, as the text of the outermost message
    /// does not say its package, by its last name alone.
    fn find(&self, kind: &str, package: &str) -> Option<(&'a str, &'a str)> {
        let types = &self.0;
        let local = format!("{package}/{kind}");
        let ending = format!("/{kind}");
        let exact = types
            .get_key_value(kind)
            .or_else(|| types.get_key_value(local.as_str()));
        let (name, text) =
            exact.or_else(|| types.iter().find(|(name, _)| name.ends_with(&ending)))?;
        Some((name, text))
    }
}

enum Count {
    One,
    Exactly(usize),
    Sent,
}

fn split_array(kind: &str) -> Option<(&str, Count)> {
    match kind.split_once('[') {
        None => Some((kind, Count::One)),
        Some((kind, "]")) => Some((kind, Count::Sent)),
        Some((kind, count)) => Some((kind, Count::Exactly(count.strip_suffix(']')?.parse().ok()?))),
    }
}
