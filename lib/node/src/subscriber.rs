//! Subscribers that notice a dead link, by the age of what they heard, and dial again.

use crate::acknowledgement;
use crate::bounded::Bounded;
use crate::environment;
use crate::link::{Report, Tended};
use crate::service::resolved;
use crate::xmlrpc::authority;

use rosrust::Message;
use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The longest pause between two attempts to dial a silent publisher again.
const REDIAL_MAX: Duration = Duration::from_secs(8);
/// Pause between looks for a publisher; rosrust tells nobody when one comes.
const PUBLISHER_PERIOD: Duration = Duration::from_millis(20);

/// Pause between attempts to make a connection again that has ended.
const RETRY: Duration = Duration::from_secs(1);
/// How long after dialling the end of a connection may be that of the old one.
const OWN_END: Duration = Duration::from_millis(2500);

/// What a subscriber may expect of its topic.
#[derive(Debug, Clone, Copy)]
pub struct Expect {
    /// Messages kept while the callback is busy; the oldest go first.
    pub queue: usize,
    /// Whether silence is a trouble that diagnostics tell; otherwise nobody need publish the topic.
    pub required: bool,
    /// A silence after which the link is taken for dead. Latched topics of this package are repeated each second, regular
    /// ones come at their rate.
    pub silence_max: Duration,
}

impl Expect {
    /// State at a high rate, of which only the newest matters.
    pub const STATE: Self = Self {
        queue: 1,
        required: true,
        silence_max: Duration::from_millis(1000),
    };
    /// The same where messages about other things share the topic, as with joint states: in a queue of one they would push
    /// it out.
    pub const SHARED_STATE: Self = Self {
        queue: 8,
        ..Self::STATE
    };
    /// State that need not be there.
    pub const OPTIONAL_STATE: Self = Self {
        required: false,
        ..Self::STATE
    };
    /// Events of which each matters; latched by their publisher.
    pub const EVENTS: Self = Self {
        queue: 16,
        required: false,
        silence_max: Duration::from_millis(3500),
    };
    /// Commands, which are silent while nothing is to be done. Dialled again only when a link has ended: a command that
    /// comes meanwhile would be lost, and nobody repeats it.
    pub const COMMANDS: Self = Self {
        queue: 64,
        required: false,
        silence_max: Duration::MAX,
    };
    /// Latched topics of others, which need not repeat them; dialled again now and then.
    pub const SPORADIC: Self = Self {
        queue: 64,
        required: false,
        silence_max: Duration::from_secs(10),
    };
}

/// A topic that this node reads, until dropped.
#[derive(Clone)]
pub struct Subscriber {
    core: Arc<Core>,
}

type Connect = Box<dyn Fn() -> rosrust::error::Result<rosrust::Subscriber> + Send + Sync>;

struct Core {
    topic: String,
    expect: Expect,
    connect: Connect,
    link: Mutex<Link>,
    heard: Arc<Heard>,
    begun: Instant,
}

struct Link {
    handle: Option<rosrust::Subscriber>,
    dialled: Instant,
    pause: Duration,
    /// Whether a connection of an unwatched topic has ended and was not made again.
    lost: bool,
}

#[derive(Default)]
struct Heard {
    count: AtomicU64,
    lost: AtomicU64,
    /// Numbers of the last messages by publisher.
    numbers: Mutex<HashMap<String, u32>>,
    /// Nodes that publish the topic, as of late.
    publishers: AtomicUsize,
    latest: Mutex<Option<Instant>>,
}

impl Subscriber {
    pub(crate) fn new<T: Message>(
        topic: &str,
        expect: Expect,
        callback: impl Fn(T) + Send + Sync + 'static,
    ) -> rosrust::error::Result<Self> {
        let heard = Arc::new(Heard::default());
        let callback = Arc::new(callback);
        let connect: Connect = Box::new({
            let (topic, heard) = (topic.to_owned(), Arc::clone(&heard));
            move || {
                let (heard, callback) = (Arc::clone(&heard), Arc::clone(&callback));
                let note = move |Bounded(message, number): Bounded<T>, publisher: &str| {
                    acknowledgement::send();
                    heard.note(number, publisher);
                    callback(message);
                };
                rosrust::subscribe_with_ids(&topic, expect.queue, note)
            }
        });
        let link = Link {
            handle: Some(connect()?),
            dialled: Instant::now(),
            pause: expect.silence_max,
            lost: false,
        };
        let core = Core {
            topic: topic.into(),
            expect,
            connect,
            link: Mutex::new(link),
            heard,
            begun: Instant::now(),
        };
        Ok(Self {
            core: Arc::new(core),
        })
    }

    pub(crate) fn tended(&self) -> Arc<dyn Tended> {
        Arc::clone(&self.core) as Arc<dyn Tended>
    }

    /// Waits until somebody publishes, so that what is sent from now on arrives; `false` when nobody does in time.
    pub async fn until_connected(&self, patience: Duration) -> bool {
        let deadline = Instant::now() + patience;
        while !self.core.is_connected() {
            if Instant::now() >= deadline {
                return false;
            }
            tokio::time::sleep(PUBLISHER_PERIOD).await;
        }
        true
    }

    /// How long nothing has come; `None` if nothing ever has.
    pub fn age(&self) -> Option<Duration> {
        self.core.heard.latest().map(|latest| latest.elapsed())
    }
}

impl Heard {
    fn note(&self, number: Option<u32>, publisher: &str) {
        if let Some(number) = number {
            let mut numbers = self.numbers.lock().unwrap_or_else(PoisonError::into_inner);
            let last = numbers.insert(publisher.to_owned(), number);
            // A number that went back is that of a publisher that began again.
            let gap = last.and_then(|last| number.checked_sub(last)?.checked_sub(1));
            self.lost
                .fetch_add(gap.unwrap_or(0).into(), Ordering::Relaxed);
        }
        self.count.fetch_add(1, Ordering::Relaxed);
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    fn latest(&self) -> Option<Instant> {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Core {
    fn is_connected(&self) -> bool {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        link.handle
            .as_ref()
            .is_some_and(|handle| handle.publisher_count() > 0)
    }

    /// Whether there is somebody to dial: rosrust forgets a publisher that did not answer when it was asked. None where
    /// the master is out of reach, for whom rosrust waits as long as TCP does.
    fn has_publisher(&self, count: usize) -> bool {
        let announced = |name: String| {
            let topics = rosrust::state().map(|state| state.publishers);
            topics.is_ok_and(|topics| topics.iter().any(|topic| topic.name == name))
        };
        environment::check_master().is_ok()
            && (count > 0 || resolved(&self.topic).is_ok_and(announced))
    }

    /// Dials again after a connection has ended, until the publisher answers.
    fn retry(&self, link: &mut Link) {
        link.dialled = Instant::now();
        if self.has_publisher(0) {
            self.redial(link);
            let count = link.handle.as_ref().map(|handle| handle.publisher_count());
            link.lost = count.unwrap_or(0) == 0;
        }
    }

    /// Drops the link and dials all publishers anew: rosrust never redials one that it believes to be connected.
    fn redial(&self, link: &mut Link) {
        link.handle = None;
        link.dialled = Instant::now();
        match (self.connect)() {
            Ok(handle) => link.handle = Some(handle),
            Err(error) => log::error!("cannot subscribe to {}: {error}", self.topic),
        }
    }
}

impl Tended for Core {
    fn tend(&self) {
        let mut link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        // Noted here, since whoever reports must not wait for a link that is being dialled.
        let publishers = link
            .handle
            .as_ref()
            .map_or(0, |handle| handle.publisher_count());
        self.heard.publishers.store(publishers, Ordering::Relaxed);
        if link.lost && link.dialled.elapsed() >= RETRY {
            return self.retry(&mut link);
        }
        let latest = self.heard.latest();
        let silent_since = latest.map_or(link.dialled, |latest| latest.max(link.dialled));
        if latest.is_some_and(|latest| latest > link.dialled) {
            link.pause = self.expect.silence_max;
        }
        if silent_since.elapsed() < link.pause {
            return;
        }
        link.pause = (link.pause * 2).min(REDIAL_MAX.max(self.expect.silence_max));
        let count = link
            .handle
            .as_ref()
            .map_or(0, |handle| handle.publisher_count());
        if !self.has_publisher(count) {
            link.dialled = Instant::now();
            return;
        }
        log::debug!("{} is silent; dialling again", self.topic);
        self.redial(&mut link);
    }

    fn lost(&self, gone: &[SocketAddr]) {
        let mut link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        let watched = self.expect.silence_max != Duration::MAX;
        if watched || gone.is_empty() || link.dialled.elapsed() < OWN_END {
            return;
        }
        let publishers = link.handle.as_ref().map(|handle| handle.publisher_uris());
        let is_publisher = |uri: &String| gone.iter().any(|end| may_carry(uri, *end));
        if publishers.is_some_and(|uris| uris.iter().any(is_publisher)) {
            log::debug!("a link of {} has ended; dialling again", self.topic);
            link.lost = true;
        }
    }

    fn renew(&self) {
        self.redial(&mut self.link.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn close(&self) {
        self.link
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .handle = None;
    }

    fn report(&self) -> Option<Report> {
        Some(Report {
            topic: self.topic.clone(),
            count: self.heard.count.load(Ordering::Relaxed),
            lost: self.heard.lost.load(Ordering::Relaxed),
            silent: self.heard.latest().unwrap_or(self.begun).elapsed(),
            silence_max: self.expect.required.then_some(self.expect.silence_max),
            publishers: self.heard.publishers.load(Ordering::Relaxed),
        })
    }
}

/// Whether a connection to `end` may carry a topic of the node at `uri`: it is to the same computer, but not to the port
/// that answers questions.
fn may_carry(uri: &str, end: SocketAddr) -> bool {
    let Some((host, port)) = authority(uri).and_then(|whole| whole.rsplit_once(':')) else {
        return false;
    };
    let same_host = host.parse::<IpAddr>().map_or(true, |host| host == end.ip());
    same_host && port != end.port().to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn only_other_ports_of_the_publisher_carry_its_topics() {
        let end = "10.0.0.2:4712".parse().unwrap();
        assert!(may_carry("http://10.0.0.2:4711/", end));
        assert!(may_carry("http://arm:4711/", end), "names are not resolved");
        assert!(!may_carry("http://10.0.0.2:4712/", end));
        assert!(!may_carry("http://10.0.0.3:4711/", end));
    }
}
