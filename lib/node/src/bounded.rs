//! Messages and services whose bytes are checked against their [`Layout`] before rosrust decodes them.

use crate::layout::Layout;
use msg::service::Service;
use rosrust::{Clock, Message, RosMsg};
use std::any::TypeId;
use std::collections::HashMap;
use std::io;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// A message of type `T` that came from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounded<T>(pub T);

impl<T: Message> RosMsg for Bounded<T> {
    fn encode<W: io::Write>(&self, writer: W) -> io::Result<()> {
        self.0.encode(writer)
    }

    fn decode<R: io::Read>(reader: R) -> io::Result<Self> {
        decode_checked(reader, T::msg_definition).map(Bounded)
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
        decode_checked(reader, S::request_definition).map(Request)
    }
}

impl<S: Service> RosMsg for Response<S> {
    fn encode<W: io::Write>(&self, writer: W) -> io::Result<()> {
        self.0.encode(writer)
    }
    fn decode<R: io::Read>(reader: R) -> io::Result<Self> {
        decode_checked(reader, S::response_definition).map(Response)
    }
}

/// Decodes a `T` whose definition is `definition`, after its lengths were found to fit what arrived.
fn decode_checked<T: RosMsg + 'static, R: io::Read>(
    mut reader: R,
    definition: fn() -> String,
) -> io::Result<T> {
    let layout = cached_layout::<T>(definition)?;
    let mut bytes = Vec::new();
    layout.read(&mut reader, &mut bytes)?;
    T::decode(&bytes[..])
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

        let mut forged = vec![28, 0, 0, 0];
        forged.extend_from_slice(&[0; 16]);
        forged.extend_from_slice(&0x7fff_ffffu32.to_le_bytes());
        forged.extend_from_slice(&[0; 8]);
        assert!(Bounded::<JointState>::decode_slice(&forged).is_err());
    }
}
