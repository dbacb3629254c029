//! Whoever waits for the answer of a service.

use std::io;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

/// Pause between two looks at the connection.
const LOOK_PERIOD: Duration = Duration::from_millis(50);

/// The far end of a service call. Clones share it.
#[derive(Clone)]
pub struct Caller {
    stream: Arc<TcpStream>,
    name: Arc<str>,
}

impl Caller {
    pub(crate) fn new(stream: TcpStream, name: &str) -> Self {
        Self {
            stream: Arc::new(stream),
            name: name.into(),
        }
    }

    /// Name of the node that calls, as it says.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns once the caller has hung up, has died, or cannot be reached any more; never while it waits.
    pub async fn gone(&self) {
        while self.is_there() {
            tokio::time::sleep(LOOK_PERIOD).await;
        }
    }

    /// A caller that waits sends nothing and keeps the connection open.
    fn is_there(&self) -> bool {
        // While the service is at work nobody else reads from this connection.
        let looked = self
            .stream
            .set_nonblocking(true)
            .and_then(|()| self.stream.peek(&mut [0]));
        let restored = self.stream.set_nonblocking(false);
        let open = match looked {
            Ok(count) => count > 0,
            Err(error) => error.kind() == io::ErrorKind::WouldBlock,
        };
        open && restored.is_ok()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::net::TcpListener;

    #[tokio::test]
    async fn a_caller_is_there_until_it_hangs_up() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let caller_end = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let caller = Caller::new(listener.accept().unwrap().0, "/somebody");
        let waited = tokio::time::timeout(3 * LOOK_PERIOD, caller.gone()).await;
        assert!(waited.is_err(), "still there");
        drop(caller_end);
        let waited = tokio::time::timeout(10 * LOOK_PERIOD, caller.gone()).await;
        assert!(waited.is_ok(), "gone");
    }
}
