//! What a node hears: how often, how long ago, how much of it, and whether that is as it should be.

use super::Level;
use msg::diagnostic_msgs::KeyValue;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// From so many times the silence that is a warning on it is an error.
const ERROR_FACTOR: u32 = 3;

/// What came on a topic that this node reads.
#[derive(Debug, Clone)]
pub(crate) struct Report {
    /// Name of the topic, as it was given.
    pub topic: String,
    /// Messages heard.
    pub count: u64,
    /// Messages that did not come, by the numbers in the headers of those that did.
    pub lost: u64,
    /// Since the last message, or since the node has listened.
    pub silent: Duration,
    /// Silence from which on something is wrong; `None` where silence says nothing.
    pub silence_max: Option<Duration>,
    /// Nodes that publish the topic and are connected.
    pub publishers: usize,
}

/// Remembers counts from one report to the next, of which rates are made.
#[derive(Debug, Default)]
pub(super) struct Links {
    last: HashMap<String, (u64, Instant)>,
}

impl Links {
    /// The state of all links together, in words that name those in trouble, and each by itself.
    pub fn judge(&mut self, reports: &[Report], now: Instant) -> (Level, String, Vec<KeyValue>) {
        let troubles: Vec<_> = reports.iter().filter_map(trouble).collect();
        let level = troubles
            .iter()
            .map(|(level, _)| *level)
            .max()
            .unwrap_or(Level::Ok);
        let words: Vec<_> = troubles.into_iter().map(|(_, words)| words).collect();
        let message = match &words[..] {
            [] => "as they should be".into(),
            words => words.join("; "),
        };
        let values = reports
            .iter()
            .map(|report| self.value(report, now))
            .collect();
        (level, message, values)
    }

    fn value(&mut self, report: &Report, now: Instant) -> KeyValue {
        let rate_hz = self.rate_hz(report, now);
        let last = match report.count {
            0 => "never".into(),
            _ => format!("{:.1} s ago", report.silent.as_secs_f64()),
        };
        KeyValue {
            key: report.topic.clone(),
            value: format!(
                "{} messages, {rate_hz:.1} Hz, last {last}, {} lost",
                report.count, report.lost
            ),
        }
    }

    /// Messages a second since the last report.
    fn rate_hz(&mut self, report: &Report, now: Instant) -> f64 {
        let last = self.last.insert(report.topic.clone(), (report.count, now));
        let Some((count, when)) = last else {
            return 0.0;
        };
        let elapsed_s = now.saturating_duration_since(when).as_secs_f64();
        let news = report.count.saturating_sub(count) as f64;
        if elapsed_s > 0.0 {
            news / elapsed_s
        } else {
            0.0
        }
    }
}

/// What is wrong with a topic that must not be silent.
fn trouble(report: &Report) -> Option<(Level, String)> {
    let silence_max: Duration = report.silence_max?;
    if report.silent <= silence_max {
        return None;
    }
    let level = if report.silent > silence_max * ERROR_FACTOR {
        Level::Error
    } else {
        Level::Warn
    };
    let (topic, silent_s) = (&report.topic, report.silent.as_secs_f64());
    let who = match report.publishers {
        0 => "nobody publishes it",
        _ => "its publisher is silent",
    };
    let words = match report.count {
        0 => format!("nothing on {topic} yet: {who}"),
        _ => format!("nothing on {topic} for {silent_s:.1} s: {who}"),
    };
    Some((level, words))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(topic: &str, count: u64, silent_s: f64, required: bool) -> Report {
        Report {
            topic: topic.into(),
            count,
            lost: 2,
            silent: Duration::from_secs_f64(silent_s),
            silence_max: required.then_some(Duration::from_secs(1)),
            publishers: 1,
        }
    }

    #[test]
    fn silence_is_a_warning_then_an_error_and_names_the_topic() {
        let (mut links, now) = (Links::default(), Instant::now());
        let mut judge = |silent_s| {
            let reports = [
                report("image", 9, silent_s, true),
                report("rare", 0, 99.0, false),
            ];
            let (level, message, _) = links.judge(&reports, now);
            (level, message)
        };
        assert_eq!(judge(0.5), (Level::Ok, "as they should be".into()));
        let words = |seconds| format!("nothing on image for {seconds} s: its publisher is silent");
        assert_eq!(judge(2.0), (Level::Warn, words("2.0")));
        assert_eq!(judge(4.0), (Level::Error, words("4.0")));
        let never = Report {
            publishers: 0,
            ..report("image", 0, 4.0, true)
        };
        let (level, message, _) = Links::default().judge(&[never], now);
        assert_eq!(level, Level::Error);
        assert_eq!(message, "nothing on image yet: nobody publishes it");
    }

    #[test]
    fn rates_are_of_the_time_between_two_reports() {
        let (mut links, now) = (Links::default(), Instant::now());
        links.judge(&[report("image", 10, 0.0, true)], now);
        let later = now + Duration::from_secs(2);
        let (_, _, values) = links.judge(&[report("image", 70, 0.0, true)], later);
        assert_eq!(
            values[0].value,
            "70 messages, 30.0 Hz, last 0.0 s ago, 2 lost"
        );
    }
}
