//! Decoding of messages and services. Their bytes are checked against their [`Layout`] before rosrust decodes them.

use crate::layout::Layout;
use msg::service::Service;
use rosrust::{Message, RosMsg};
use std::any::TypeId;
use std::collections::HashMap;
use std::io;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// Decodes a message that came from outside; also returns the number in its header, if it has one.
pub(crate) fn message<T: Message>(bytes: &mut [u8]) -> io::Result<(T, Option<u32>)> {
    let message = decode(bytes, T::msg_definition)?;
    let number = bytes.first_chunk().filter(|_| starts_with_header::<T>());
    Ok((message, number.map(|number| u32::from_le_bytes(*number))))
}

/// Decodes a request of `S`.
pub(crate) fn request<S: Service>(bytes: &mut [u8]) -> io::Result<S::Request> {
    decode(bytes, S::request_definition)
}

/// Decodes a response of `S`.
pub(crate) fn response<S: Service>(bytes: &mut [u8]) -> io::Result<S::Response> {
    decode(bytes, S::response_definition)
}

/// Decodes a `T` whose definition is `definition`, after its lengths were found to fit what arrived.
fn decode<T: RosMsg + 'static>(bytes: &mut [u8], definition: fn() -> String) -> io::Result<T> {
    cached_layout::<T>(definition)?.check(bytes)?;
    T::decode(&bytes[..])
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
    use msg::std_msgs::Float64;

    fn encoded<T: Message>(message: &T) -> Vec<u8> {
        message.encode_vec().unwrap()[4..].to_vec()
    }

    #[test]
    fn good_messages_pass_and_forged_ones_do_not() {
        let message = JointState {
            name: vec!["left_w2".into()],
            position: vec![0.5],
            ..Default::default()
        };
        let mut bytes = encoded(&message);
        let decoded = super::message::<JointState>(&mut bytes).unwrap();
        assert_eq!(decoded, (message.clone(), Some(0)));

        let mut numbered = message;
        numbered.header.seq = 7;
        let decoded = super::message::<JointState>(&mut encoded(&numbered)).unwrap();
        assert_eq!(decoded, (numbered, Some(7)));
        let number = Float64 { data: 1.0 };
        let decoded = super::message::<Float64>(&mut encoded(&number)).unwrap();
        assert_eq!(decoded.1, None);

        let mut forged = vec![0; 16];
        forged.extend_from_slice(&0x7fff_ffffu32.to_le_bytes());
        forged.extend_from_slice(&[0; 8]);
        assert!(super::message::<JointState>(&mut forged).is_err());
    }
}
