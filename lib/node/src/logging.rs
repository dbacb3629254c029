//! The `log` macros to the terminal and, for our own records, to /rosout.

use log::{Level, LevelFilter, Log, Metadata, Record};
use std::sync::OnceLock;

/// Libraries that log while they hold rosrust's global lock, so that their records must not go through it again.
const TERMINAL_ONLY: [&str; 6] = ["rosrust", "xml_rpc", "hyper", "tiny_http", "ort", "tokio"];

/// Levels of `rosgraph_msgs/Log`.
const ROS_DEBUG: i8 = 1;
const ROS_INFO: i8 = 2;
const ROS_WARN: i8 = 4;
const ROS_ERROR: i8 = 8;

struct Logger {
    node: OnceLock<String>,
}

static LOGGER: Logger = Logger {
    node: OnceLock::new(),
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
pub(crate) fn connect(node: &str) {
    // A second call would only repeat the same name.
    let _ = LOGGER.node.set(node.into());
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        let ours = !TERMINAL_ONLY
            .iter()
            .any(|name| metadata.target().starts_with(name));
        ours || metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let ours = !TERMINAL_ONLY
            .iter()
            .any(|name| record.target().starts_with(name));
        let (text, file) = (record.args().to_string(), record.file().unwrap_or_default());
        if ours && self.node.get().is_some() && rosrust::is_initialized() {
            let level = match record.level() {
                Level::Error => ROS_ERROR,
                Level::Warn => ROS_WARN,
                Level::Info => ROS_INFO,
                Level::Debug | Level::Trace => ROS_DEBUG,
            };
            rosrust::log(level, text, file, record.line().unwrap_or_default());
        } else {
            eprintln!("[{} {}]: {text}", record.level(), record.target());
        }
    }

    fn flush(&self) {}
}
