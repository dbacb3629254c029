//! Values that count only while they are fresh.

use std::time::{Duration, Instant};

/// A value with its time of arrival.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aged<T> {
    /// The value.
    pub value: T,
    /// Time of its arrival by this computer's monotonic clock.
    pub received: Instant,
}

impl<T> Aged<T> {
    /// A value that arrived at this time.
    pub fn new(value: T, received: Instant) -> Self {
        Self { value, received }
    }
}

/// Why there is no fresh message on a topic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Silence {
    /// No message has arrived yet.
    Never,
    /// The last message is too old.
    Stale {
        /// Its age, s.
        age_s: f64,
        /// Largest age that counts, s.
        max_s: f64,
    },
}

/// The last value, if there is one and it is not older than `age_max`.
///
/// # Errors
/// [`Silence`]: there is none, or it is too old.
pub fn fresh<T>(last: Option<&Aged<T>>, age_max: Duration, now: Instant) -> Result<&T, Silence> {
    let last = last.ok_or(Silence::Never)?;
    let age = now.saturating_duration_since(last.received);
    if age > age_max {
        let (age_s, max_s) = (age.as_secs_f64(), age_max.as_secs_f64());
        return Err(Silence::Stale { age_s, max_s });
    }
    Ok(&last.value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_heard_a_short_while_ago_counts() {
        let (now, age_max) = (Instant::now(), Duration::from_millis(500));
        let last = Aged::new(7, now);
        let at = |elapsed_ms| {
            let now = now + Duration::from_millis(elapsed_ms);
            fresh(Some(&last), age_max, now).copied()
        };
        assert_eq!(fresh::<i32>(None, age_max, now), Err(Silence::Never));
        assert_eq!(at(500), Ok(7));
        let (age_s, max_s) = (0.75, 0.5);
        assert_eq!(at(750), Err(Silence::Stale { age_s, max_s }));
        let before = now.checked_sub(Duration::from_secs(1)).unwrap_or(now);
        assert_eq!(fresh(Some(&last), age_max, before), Ok(&7));
    }
}
