//! Messages between the connections that they came on and the callback, which has a thread of its own.

use crate::shutdown::THREADS;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The messages of a topic that wait for its callback, and what is known of all that came.
pub(crate) struct Inbox {
    /// Messages that wait at most; the oldest go first.
    queue: usize,
    state: Mutex<State>,
    news: Condvar,
}

#[derive(Debug)]
struct State {
    waiting: VecDeque<(Arc<str>, Vec<u8>)>,
    is_closed: bool,
    heard: Heard,
    /// Numbers of the last messages by publisher.
    numbers: HashMap<Arc<str>, u32>,
}

/// What came on a topic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// Messages that the callback got.
    pub count: u64,
    /// Messages that did not come, by the numbers in the headers of those that did.
    pub lost: u64,
    /// When the last one came.
    pub latest: Option<Instant>,
    /// Since when the node has listened.
    pub begun: Instant,
}

impl Inbox {
    /// An inbox whose messages `read` decodes and hands to the callback, one at a time. Before the callback it calls its second
    /// argument with the number in the message's header, if there is one.
    ///
    /// # Errors
    /// Where no thread can be had.
    pub fn start(
        topic: &str,
        queue: usize,
        read: impl Fn(Vec<u8>, &dyn Fn(Option<u32>)) -> std::io::Result<()> + Send + 'static,
    ) -> std::io::Result<Arc<Self>> {
        let heard = Heard {
            count: 0,
            lost: 0,
            latest: None,
            begun: Instant::now(),
        };
        let inbox = Arc::new(Self {
            queue: queue.max(1),
            state: Mutex::new(State {
                waiting: VecDeque::new(),
                is_closed: false,
                heard,
                numbers: HashMap::new(),
            }),
            news: Condvar::new(),
        });
        let (reader, topic, running) = (Arc::clone(&inbox), topic.to_owned(), THREADS.begin());
        let thread = std::thread::Builder::new().name(format!("topic {topic}"));
        thread.spawn(move || {
            let _running = running;
            while let Some((publisher, bytes)) = reader.next() {
                let note = |number| reader.state().note(&publisher, number);
                if let Err(error) = read(bytes, &note) {
                    log::debug!("{topic} of {publisher}: {error}");
                }
            }
        })?;
        Ok(inbox)
    }

    pub fn put(&self, publisher: &str, bytes: Vec<u8>) {
        let mut state = self.state();
        if state.waiting.len() >= self.queue {
            state.waiting.pop_front();
        }
        state.waiting.push_back((publisher.into(), bytes));
        drop(state);
        self.news.notify_one();
    }

    /// Ends the thread after the message that it is at.
    pub fn close(&self) {
        self.state().is_closed = true;
        self.news.notify_one();
    }

    pub fn heard(&self) -> Heard {
        self.state().heard
    }

    fn next(&self) -> Option<(Arc<str>, Vec<u8>)> {
        let mut state = self.state();
        loop {
            if state.is_closed {
                return None;
            }
            if let Some(message) = state.waiting.pop_front() {
                return Some(message);
            }
            state = self
                .news
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn note(&mut self, publisher: &Arc<str>, number: Option<u32>) {
        if let Some(number) = number {
            let last = self.numbers.insert(Arc::clone(publisher), number);
            // A number that went back is that of a publisher that began again.
            let gap = last.and_then(|last| number.checked_sub(last)?.checked_sub(1));
            self.heard.lost += u64::from(gap.unwrap_or(0));
        }
        self.heard.count += 1;
        self.heard.latest = Some(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn the_newest_are_kept_and_gaps_are_counted() {
        let (begun, begins) = mpsc::channel();
        let (go, goes) = mpsc::channel::<()>();
        let read = move |bytes: Vec<u8>, note: &dyn Fn(Option<u32>)| {
            note(Some(u32::from(bytes[0])));
            begun.send(bytes[0]).unwrap();
            goes.recv().unwrap();
            Ok(())
        };
        let inbox = Inbox::start("topic", 2, read).unwrap();
        inbox.put("/a", vec![0]);
        assert_eq!(begins.recv().unwrap(), 0);
        (1..6).for_each(|number| inbox.put("/a", vec![number]));
        for number in [4, 5] {
            go.send(()).unwrap();
            assert_eq!(begins.recv().unwrap(), number);
        }
        inbox.close();
        go.send(()).unwrap();
        assert_eq!(begins.recv().ok(), None, "the thread has ended");
        let heard = inbox.heard();
        assert_eq!((heard.count, heard.lost), (3, 3));
    }
}
