//! Messages and services whose bytes are checked against their [`Layout`] before rosrust decodes them.

use crate::layout::Layout;
use msg::service::Service;
use rosrust::{Clock, Message, RosMsg};
use std::any::TypeId;
use std::collections::HashMap;
use std::io;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// A message of type `T` that came from outside, and the number in its header, if it has one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounded<T>(pub T, pub Option<u32>);

impl<T: Message> RosMsg for Bounded<T> {
    fn encode<W: io::Write>(&self, writer: W) -> io::Result<()> {
        self.0.encode(writer)
    }

    fn decode<R: io::Read>(reader: R) -> io::Result<Self> {
        let (message, bytes) = decode_checked(reader, T::msg_definition)?;
        let number = starts_with_header::<T>().then(|| {
            bytes
                .first_chunk()
                .map(|number| u32::from_le_bytes(*number))
        });
        Ok(Self(message, number.flatten()))
    }
}

impl<T: Message> Message for Bounded<T> {
    fn msg_definition() -> String {
        T::msg_definition()
    }
    fn md5sum() -> String {
        T::md5sum()
    }
    fn msg_type() -> String {
        T::msg_type()
    }
    fn set_header(&mut self, clock: &Arc<dyn Clock>, seq: &Arc<AtomicUsize>) {
        self.0.set_header(clock, seq);
    }
}

/// A request of `S`.
pub struct Request<S: Service>(pub S::Request);

/// A response of `S`.
pub struct Response<S: Service>(pub S::Response);

impl<S: Service> RosMsg for Request<S> {
    fn encode<W: io::Write>(&self, writer: W) -> io::Result<()> {
        self.0.encode(writer)
    }
    fn decode<R: io::Read>(reader: R) -> io::Result<Self> {
        decode_checked(reader, S::request_definition).map(|(request, _)| Request(request))
    }
}

impl<S: Service> RosMsg for Response<S> {
    fn encode<W: io::Write>(&self, writer: W) -> io::Result<()> {
        self.0.encode(writer)
    }
    fn decode<R: io::Read>(reader: R) -> io::Result<Self> {
        decode_checked(reader, S::response_definition).map(|(response, _)| Response(response))
    }
}

/// Decodes a `T` whose definition is `definition`, after its lengths were found to fit what arrived; also returns its
/// bytes.
fn decode_checked<T: RosMsg + 'static, R: io::Read>(
    mut reader: R,
    definition: fn() -> String,
) -> io::Result<(T, Vec<u8>)> {
    let layout = cached_layout::<T>(definition)?;
    let mut bytes = Vec::new();
    layout.read(&mut reader, &mut bytes)?;
    let decoded = T::decode(&bytes[..])?;
    Ok((decoded, bytes))
}

/// Whether messages of this type begin with a header, whose number is its first field.
fn starts_with_header<T: Message>() -> bool {
    static HEADERS: LazyLock<Mutex<HashMap<TypeId, bool>>> = LazyLock::new(Mutex::default);
    let mut headers = HEADERS.lock().unwrap_or_else(PoisonError::into_inner);
    *headers.entry(TypeId::of::<T>()).or_insert_with(|| {
        let definition = T::msg_definition();
        let code = |line: &str| line.split('#').next().unwrap_or_default().trim().to_owned();
        let first = definition.lines().map(code).find(|line| !line.is_empty());
        let kind = first.and_then(|line| line.split_whitespace().next().map(str::to_owned));
        matches!(kind.as_deref(), Some("Header" | "std_msgs/Header"))
    })
}

fn cached_layout<T: 'static>(definition: fn() -> String) -> io::Result<Arc<Layout>> {
    static LAYOUTS: LazyLock<Mutex<HashMap<TypeId, Arc<Layout>>>> = LazyLock::new(Mutex::default);
    let mut layouts = LAYOUTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(layout) = layouts.get(&TypeId::of::<T>()) {
        return Ok(Arc::clone(layout));
    }
    let layout = Layout::parse(&definition())
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    let layout = Arc::new(layout);
    layouts.insert(TypeId::of::<T>(), Arc::clone(&layout));
    Ok(layout)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use msg::sensor_msgs::JointState;

    #[test]
    fn good_messages_pass_and_forged_ones_do_not() {
        let message = JointState {
            name: vec!["left_w2".into()],
            position: vec![0.5],
            ..Default::default()
        };
        let bytes = message.encode_vec().unwrap();
        assert_eq!(
            Bounded::<JointState>::decode_slice(&bytes).unwrap().0,
            message
        );

        let mut numbered = message.clone();
        numbered.header.seq = 7;
        let bytes = numbered.encode_vec().unwrap();
        let decoded = Bounded::<JointState>::decode_slice(&bytes).unwrap();
        assert_eq!(decoded, Bounded(numbered, Some(7)));
        let bytes = msg::std_msgs::Float64 { data: 1.0 }.encode_vec().unwrap();
        let decoded = Bounded::<msg::std_msgs::Float64>::decode_slice(&bytes).unwrap();
        assert_eq!(decoded.1, None);

        let mut forged = vec![28, 0, 0, 0];
        forged.extend_from_slice(&[0; 16]);
        forged.extend_from_slice(&0x7fff_ffffu32.to_le_bytes());
        forged.extend_from_slice(&[0; 8]);
        assert!(Bounded::<JointState>::decode_slice(&forged).is_err());
    }
}
