//! Sizes of a message on the wire, checked before anything is allocated for it.
//!
//! rosrust believes each array length that arrives and allocates it unchecked: 28 bytes of a forged `JointState` abort the
//! process. A [`Layout`] is made of the message's own definition text and walks the bytes first.

use std::collections::HashMap;
use std::io::{self, Read};
use thiserror::Error;

/// Bytes of one message that are taken at most; an uncompressed 848 × 480 cloud has 13 MB.
pub const MESSAGE_BYTES_MAX: usize = 64 << 20;

/// Elements of arrays whose elements differ in size, in one message, at most. They are larger in memory than on the wire: an
/// empty string takes 4 bytes there and 24 here.
pub const ELEMENTS_MAX: usize = 1 << 16;

/// Messages within messages; the definitions in use need 4.
const DEPTH_MAX: usize = 16;

/// A definition text that makes no sense.
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

/// The wire format of a message: what follows what, and which lengths are read from the wire.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout(Vec<Item>);

#[derive(Debug, Clone, PartialEq)]
enum Item {
    /// So many bytes, whatever they say.
    Fixed(usize),
    /// So many truth values, 0 or 1. rosrust would take other bytes for a `bool` as they are, which is undefined in Rust.
    Truth(usize),
    /// An array whose length precedes it; a string is one of 1-byte elements.
    Array(Layout),
}

impl Layout {
    /// Parses a definition with the messages that it uses, as connection headers carry it.
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
        message_layout(own, "", &types, 0)
    }

    /// Reads exactly one message from `reader` into `bytes`, which grows as bytes arrive, never ahead of them.
    pub fn read(&self, reader: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<()> {
        self.read_counting(reader, bytes, &mut 0)
    }

    fn read_counting(
        &self,
        reader: &mut impl Read,
        bytes: &mut Vec<u8>,
        elements: &mut usize,
    ) -> io::Result<()> {
        for item in &self.0 {
            match item {
                Item::Fixed(size) => take(reader, *size, bytes)?,
                Item::Truth(count) => take_truth(reader, *count, bytes)?,
                Item::Array(element) => {
                    let count = read_length(reader, bytes)?;
                    match element.0[..] {
                        [] => {}
                        [Item::Fixed(size)] => take(reader, count.saturating_mul(size), bytes)?,
                        [Item::Truth(each)] => {
                            take_truth(reader, count.saturating_mul(each), bytes)?;
                        }
                        _ => {
                            *elements = elements.saturating_add(count);
                            check_elements(*elements)?;
                            for _ in 0..count {
                                element.read_counting(reader, bytes, elements)?;
                            }
                        }
                    }
                }
            }
        }
        Ok(())
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

fn message_layout(
    text: &str,
    package: &str,
    types: &HashMap<&str, &str>,
    depth: usize,
) -> Result<Layout, LayoutError> {
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
        let element = type_layout(kind, package, types, depth)?;
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

fn type_layout(
    kind: &str,
    package: &str,
    types: &HashMap<&str, &str>,
    depth: usize,
) -> Result<Layout, LayoutError> {
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
            let (name, text) = find_type(kind, package, types)
                .ok_or_else(|| LayoutError::UnknownType(kind.into()))?;
            let package = name.split('/').next().unwrap_or_default();
            return message_layout(text, package, types, depth + 1);
        }
    };
    Ok(Layout(vec![Item::Fixed(size)]))
}

/// Finds `kind` by its full name, in the package of the message that uses it, or, as the text of the outermost message
/// does not say its package, by its last name alone.
fn find_type<'a>(
    kind: &str,
    package: &str,
    types: &HashMap<&'a str, &'a str>,
) -> Option<(&'a str, &'a str)> {
    let local = format!("{package}/{kind}");
    let ending = format!("/{kind}");
    let exact = types
        .get_key_value(kind)
        .or_else(|| types.get_key_value(local.as_str()));
    let (name, text) = exact.or_else(|| types.iter().find(|(name, _)| name.ends_with(&ending)))?;
    Some((name, text))
}

fn read_length(reader: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<usize> {
    let mut length = [0; 4];
    reader.read_exact(&mut length)?;
    bytes.extend_from_slice(&length);
    Ok(u32::from_le_bytes(length) as usize)
}

fn check_elements(elements: usize) -> io::Result<()> {
    if elements <= ELEMENTS_MAX {
        return Ok(());
    }
    let text = format!("message claims {elements} elements; the limit is {ELEMENTS_MAX}");
    Err(io::Error::new(io::ErrorKind::InvalidData, text))
}

/// Any byte but 0 is true, as in C++ and Python.
fn take_truth(reader: &mut impl Read, count: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    let start = bytes.len();
    take(reader, count, bytes)?;
    for byte in &mut bytes[start..] {
        *byte = u8::from(*byte != 0);
    }
    Ok(())
}

fn take(reader: &mut impl Read, size: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
    if bytes.len().saturating_add(size) > MESSAGE_BYTES_MAX {
        let text = format!("message claims {size} more bytes; the limit is {MESSAGE_BYTES_MAX}");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    let read = reader.take(size as u64).read_to_end(bytes)?;
    if read < size {
        let text = format!("message claims {size} more bytes where {read} are left");
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, text));
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod example {
    //! Messages as they might come, made of their layout alone.

    use super::{Item, Layout};
    use rand::RngExt;
    use rand_pcg::Pcg64Mcg;

    impl Layout {
        /// Bytes that this layout allows: any numbers, short arrays and strings.
        pub(crate) fn example(&self, random: &mut Pcg64Mcg, bytes: &mut Vec<u8>) {
            for item in &self.0 {
                match item {
                    Item::Fixed(size) => {
                        // Zero and one are frequent, so that flags and small counts occur.
                        let small = random.random_bool(0.5);
                        let byte = |random: &mut Pcg64Mcg| {
                            if small {
                                random.random_range(0..2)
                            } else {
                                random.random()
                            }
                        };
                        bytes.extend((0..*size).map(|_| byte(random)));
                    }
                    Item::Truth(count) => {
                        bytes.extend((0..*count).map(|_| random.random_range(0..2)));
                    }
                    Item::Array(element) => {
                        let text = *element == Self(vec![Item::Fixed(1)]);
                        let count = random.random_range(0..if text { 12 } else { 4 });
                        bytes.extend(u32::to_le_bytes(count));
                        for _ in 0..count {
                            match text {
                                true => bytes.push(random.random_range(b' '..b'~')),
                                false => element.example(random, bytes),
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rosrust::Message;

    fn layout_of<T: Message>() -> Layout {
        Layout::parse(&T::msg_definition()).unwrap()
    }

    fn encoded<T: Message>(message: &T) -> Vec<u8> {
        message.encode_vec().unwrap()[4..].to_vec()
    }

    #[test]
    fn layouts_agree_with_the_encoder() {
        let mut bytes = Vec::new();
        let view = msg::deformable_cobot::View {
            scan_id: "a scan".into(),
            timing: vec![Default::default(); 3],
            ..Default::default()
        };
        layout_of::<msg::deformable_cobot::View>()
            .read(&mut &encoded(&view)[..], &mut bytes)
            .unwrap();
        assert_eq!(bytes, encoded(&view));
        for definition in [
            <msg::deformable_cobot::RegisterViews as msg::service::Service>::request_definition(),
            <msg::deformable_cobot::ClassifyCloud as msg::service::Service>::response_definition(),
        ] {
            Layout::parse(&definition).unwrap();
        }
    }

    #[test]
    fn a_forged_joint_state_is_an_error_not_an_allocation() {
        // An empty header, then 4294967295 names in a message of 28 bytes.
        let mut forged = vec![0; 16];
        forged.extend_from_slice(&u32::MAX.to_le_bytes());
        forged.extend_from_slice(&[0; 8]);
        let mut bytes = Vec::new();
        let error = layout_of::<msg::sensor_msgs::JointState>()
            .read(&mut &forged[..], &mut bytes)
            .unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        assert!(bytes.capacity() < 1024);
    }

    #[test]
    fn fixed_fields_are_joined_and_arrays_kept() {
        let text = "uint8 A=3\nfloat64 x # m\nstring name\nPart[2] parts\n".to_owned()
            + &"=".repeat(80)
            + "\nMSG: p/Part\nint16 a\ntime[] t\n";
        let byte = Layout(vec![Item::Fixed(1)]);
        let times = Item::Array(Layout(vec![Item::Fixed(8)]));
        let expected = Layout(vec![
            Item::Fixed(8),
            Item::Array(byte),
            Item::Fixed(2),
            times.clone(),
            Item::Fixed(2),
            times,
        ]);
        assert_eq!(Layout::parse(&text), Ok(expected));
    }

    #[test]
    fn nonsense_definitions_are_refused() {
        assert!(matches!(
            Layout::parse("float64"),
            Err(LayoutError::Line(_))
        ));
        assert!(matches!(
            Layout::parse("What x"),
            Err(LayoutError::UnknownType(_))
        ));
        let recursive = format!("A a\n{}\nMSG: p/A\nA a\n", "=".repeat(80));
        assert!(matches!(
            Layout::parse(&recursive),
            Err(LayoutError::Recursive(_))
        ));
    }

    #[test]
    fn truth_is_zero_or_one() {
        let layout = Layout::parse("bool a\nbool[2] b\nuint8 c\nbool[] d").unwrap();
        let sent = [2, 0, 255, 7, 3, 0, 0, 0, 1, 9, 0];
        let mut bytes = Vec::new();
        layout.read(&mut &sent[..], &mut bytes).unwrap();
        assert_eq!(bytes, [1, 0, 1, 7, 3, 0, 0, 0, 1, 1, 0]);
    }

    #[test]
    fn many_small_elements_are_too_many() {
        let layout = Layout::parse("string[] names").unwrap();
        let count = ELEMENTS_MAX + 1;
        let mut sent = (count as u32).to_le_bytes().to_vec();
        sent.resize(4 + 4 * count, 0);
        let error = layout.read(&mut &sent[..], &mut Vec::new()).unwrap_err();
        assert!(error.to_string().contains("65537 elements"), "{error}");
    }

    #[test]
    fn elements_without_bytes_cannot_spin() {
        let text = format!("E[] many\n{}\nMSG: std_msgs/E\n", "=".repeat(80));
        let layout = Layout::parse(&text).unwrap();
        layout
            .read(&mut &u32::MAX.to_le_bytes()[..], &mut Vec::new())
            .unwrap();
    }
}
