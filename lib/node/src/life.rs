//! Who waits for a request, handed on from where it enters to the joint command that it leads to.

use crate::shutdown;
use std::sync::Arc;
use tokio::sync::watch;

/// Lives while somebody waits for the outcome of a request and this node is not told to end. Clones share it.
///
/// Nothing may move for a request whose `Life` has ended. A service's handler gets that of its call; an action's is made by
/// [`Life::until`]. [`Node::call`](crate::Node::call) hands it on to another node.
#[derive(Clone, Debug)]
pub struct Life {
    end: watch::Receiver<Option<Arc<str>>>,
}

impl Life {
    /// Lives until `reason` says why it has ended, or until this node is told to end. Must be called in the runtime.
    pub fn until(reason: impl Future<Output = String> + Send + 'static) -> Self {
        let (sender, end) = watch::channel(None);
        tokio::spawn(async move {
            let reason = tokio::select! {
                biased;
                _ = shutdown::ordered() => "the node is shutting down".to_owned(),
                reason = reason => reason,
                // Nobody holds the life any more.
                () = sender.closed() => return,
            };
            sender.send_replace(Some(reason.into()));
        });
        Self { end }
    }

    /// Lives as long as this one, and at most until `reason` says why it has ended. Must be called in the runtime.
    pub fn and_until(&self, reason: impl Future<Output = String> + Send + 'static) -> Self {
        let first = self.clone();
        Self::until(async move {
            tokio::select! {
                biased;
                reason = first.ended() => reason,
                reason = reason => reason,
            }
        })
    }

    /// The result of `work`, which is dropped where this life ends before.
    ///
    /// # Errors
    /// Why nobody waits for the work any more, or why it failed.
    pub async fn during<T>(
        &self,
        work: impl Future<Output = anyhow::Result<T>>,
    ) -> anyhow::Result<T> {
        tokio::select! {
            biased;
            reason = self.ended() => Err(anyhow::Error::msg(reason)),
            result = work => result,
        }
    }

    /// Waits until it has ended, and says why: "the caller /x hung up or died", "the node is shutting down". Never returns
    /// before.
    pub async fn ended(&self) -> String {
        let mut end = self.end.clone();
        let ended = end.wait_for(Option::is_some).await;
        match ended.as_deref() {
            Ok(Some(reason)) => reason.to_string(),
            // The runtime drops its tasks only when the process ends.
            _ => "the node is shutting down".to_owned(),
        }
    }

    /// Why it has ended; `None` while it lives.
    pub fn end(&self) -> Option<String> {
        self.end.borrow().as_deref().map(str::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[tokio::test]
    async fn a_life_ends_once_and_says_why() {
        let (end, ended) = tokio::sync::oneshot::channel();
        let life = Life::until(async { ended.await.unwrap_or_default() });
        assert_eq!(life.end(), None);
        let waited = tokio::time::timeout(Duration::from_millis(20), life.ended()).await;
        assert!(waited.is_err(), "it lives");
        assert_eq!(end.send("cancelled".to_owned()), Ok(()));
        assert_eq!(life.clone().ended().await, "cancelled");
        assert_eq!(life.end().as_deref(), Some("cancelled"));
    }

    #[tokio::test]
    async fn a_life_within_a_life_ends_with_either_and_ends_its_work() {
        for is_outer in [true, false] {
            let (end, ended) = tokio::sync::oneshot::channel::<()>();
            let ended = async move {
                let _ = ended.await;
                "over".to_owned()
            };
            let pending = std::future::pending();
            let life = match is_outer {
                true => Life::until(ended).and_until(pending),
                false => Life::until(pending).and_until(ended),
            };
            assert_eq!(life.during(async { Ok(7) }).await.ok(), Some(7));
            drop(end);
            let result = life.during(std::future::pending::<anyhow::Result<()>>());
            assert_eq!(
                result.await.map_err(|error| error.to_string()),
                Err("over".into())
            );
        }
    }

    #[tokio::test]
    async fn what_nobody_holds_is_not_watched() {
        let (watched, until_dropped) = tokio::sync::oneshot::channel::<()>();
        let life = Life::until(async move {
            let _watched = watched;
            std::future::pending().await
        });
        drop(life);
        assert!(until_dropped.await.is_err(), "the watching future is gone");
    }
}
