//! The `log` macros to the terminal and, for our own records, to /rosout.

use crate::names;
use crate::publisher::Publisher;
use log::{Level, LevelFilter, Log, Metadata, Record};
use msg::rosgraph_msgs;
use std::io::{self, IsTerminal, Write};
use std::sync::OnceLock;

/// Libraries whose records are shown from warnings on, and do not go to /rosout.
const LIBRARIES: [&str; 3] = ["rosrust", "ort", "tokio"];

struct Logger {
    rosout: OnceLock<Publisher<rosgraph_msgs::Log>>,
}

static LOGGER: Logger = Logger {
    rosout: OnceLock::new(),
};

/// Installs the logger; `RUST_LOG` (error, warn, info, debug) sets what is shown, info unless set.
pub(crate) fn install() {
    let level = std::env::var("RUST_LOG")
        .ok()
        .and_then(|text| text.parse().ok());
    if log::set_logger(&LOGGER).is_ok() {
        log::set_max_level(level.unwrap_or(LevelFilter::Info));
    }
}

/// From here on records go to /rosout too.
pub(crate) fn connect(rosout: Publisher<rosgraph_msgs::Log>) {
    // There is one node in a process.
    let _ = LOGGER.rosout.set(rosout);
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        is_ours(metadata) || metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let (file, line) = (
            record.file().unwrap_or_default(),
            record.line().unwrap_or_default(),
        );
        let (level, text) = (record.level(), record.args());
        show(level, &format!("[{level} @ {file}:{line}]: {text}"));
        if let Some(rosout) = self.rosout.get().filter(|_| is_ours(record.metadata())) {
            rosout.send(rosgraph_msgs::Log {
                level: match level {
                    Level::Error => rosgraph_msgs::Log::ERROR,
                    Level::Warn => rosgraph_msgs::Log::WARN,
                    Level::Info => rosgraph_msgs::Log::INFO,
                    Level::Debug | Level::Trace => rosgraph_msgs::Log::DEBUG,
                },
                msg: text.to_string(),
                name: names::own().into(),
                file: file.into(),
                line,
                ..Default::default()
            });
        }
    }

    fn flush(&self) {}
}

fn is_ours(metadata: &Metadata) -> bool {
    !LIBRARIES
        .iter()
        .any(|name| metadata.target().starts_with(name))
}

/// Writes a record as ROS's own loggers do: warnings and errors to stderr, in colour where that is a terminal. A node goes on
/// where nobody reads any more (`| head`), which `println!` would end.
pub(crate) fn show(level: Level, line: &str) {
    let colour = match level {
        Level::Error => "31",
        Level::Warn => "33",
        _ => {
            let _ = writeln!(io::stdout().lock(), "{line}");
            return;
        }
    };
    let mut stderr = io::stderr().lock();
    let _ = if stderr.is_terminal() {
        writeln!(stderr, "\x1b[{colour}m{line}\x1b[0m")
    } else {
        writeln!(stderr, "{line}")
    };
}
