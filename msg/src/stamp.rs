//! Stamps as times since the epoch, and back.

use rosrust::Time;
use std::time::Duration;

/// A stamp as time since the epoch.
pub fn since_epoch(stamp: Time) -> Duration {
    Duration::new(u64::from(stamp.sec), stamp.nsec)
}

/// The reverse of [`since_epoch`].
pub fn from_epoch(elapsed: Duration) -> Time {
    // ROS 1 counts seconds in 32 bits.
    Time {
        sec: elapsed.as_secs() as u32,
        nsec: elapsed.subsec_nanos(),
    }
}
