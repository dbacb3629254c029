//! Sizes of a message on the wire, checked before anything is allocated for it.
//!
//! rosrust believes each array length that arrives and allocates it unchecked: 28 bytes of a forged `JointState` abort the
//! process. A [`Layout`] is made of the message's own definition text and walks the bytes first.

#[cfg(test)]
mod example;
mod parse;

pub use parse::LayoutError;

use std::io::{self, Read};

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
    /// Reads exactly one message from `reader` into `bytes`, which grows as bytes arrive, never ahead of them.
    ///
    /// # Errors
    /// The reader fails or ends early, or a length exceeds its limit.
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
