//! How the node fares, published on /diagnostics each second (REP 107).

use crate::link::Report;
use crate::publisher::{Latch, Publisher};
use msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// How serious a state is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// As it should be.
    Ok,
    /// It works, but somebody should look.
    Warn,
    /// It does not work.
    Error,
}

/// The states of a node's parts. Clones share them.
#[derive(Clone)]
pub struct Health {
    node: String,
    parts: Arc<Mutex<BTreeMap<String, (Level, String)>>>,
    publisher: Publisher<DiagnosticArray>,
}

impl Health {
    pub(crate) fn new(node: &str, publisher: Publisher<DiagnosticArray>) -> Self {
        Self {
            node: node.trim_start_matches('/').into(),
            parts: Arc::default(),
            publisher,
        }
    }

    pub(crate) fn new_publisher() -> rosrust::error::Result<Publisher<DiagnosticArray>> {
        Publisher::new("/diagnostics", 10, Latch::No)
    }

    /// Sets the state of `part`, in words, until it is set again.
    pub fn set(&self, part: &str, level: Level, message: impl Into<String>) {
        let mut parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        parts.insert(part.into(), (level, message.into()));
    }

    pub(crate) fn publish(&self, reports: Vec<Report>) {
        let values = reports.iter().map(report_value).collect();
        let mut status = vec![self.status("links", Level::Ok, "", values)];
        let parts = self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        for (part, (level, message)) in parts.iter() {
            status.push(self.status(part, *level, message, Vec::new()));
        }
        drop(parts);
        let mut message = DiagnosticArray {
            status,
            ..Default::default()
        };
        message.header.stamp = rosrust::now();
        self.publisher.send(message);
    }

    fn status(
        &self,
        part: &str,
        level: Level,
        message: &str,
        values: Vec<KeyValue>,
    ) -> DiagnosticStatus {
        DiagnosticStatus {
            level: match level {
                Level::Ok => DiagnosticStatus::OK,
                Level::Warn => DiagnosticStatus::WARN,
                Level::Error => DiagnosticStatus::ERROR,
            },
            name: format!("{}: {part}", self.node),
            message: message.into(),
            hardware_id: String::new(),
            values,
        }
    }
}

fn report_value(report: &Report) -> KeyValue {
    let age = report.age.map_or("never".into(), |age| {
        format!("{:.1} s ago", age.as_secs_f64())
    });
    KeyValue {
        key: report.topic.clone(),
        value: format!("{} messages, last {age}", report.count),
    }
}
