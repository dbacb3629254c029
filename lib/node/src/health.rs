//! How the node fares, published on /diagnostics each second (REP 107).

mod links;

use crate::clock;
use crate::publisher::Publisher;
use links::Links;
pub(crate) use links::Report;
use msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What diagnostics say of nodes that stand for no hardware.
const NO_HARDWARE: &str = "none";

/// How serious a state is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Everything works.
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
    state: Arc<Mutex<State>>,
    publisher: Publisher<DiagnosticArray>,
}

struct State {
    hardware_id: String,
    parts: BTreeMap<String, (Level, String)>,
    links: Links,
}

impl Health {
    pub(crate) fn new(node: &str, publisher: Publisher<DiagnosticArray>) -> Self {
        let state = State {
            hardware_id: NO_HARDWARE.into(),
            parts: BTreeMap::new(),
            links: Links::default(),
        };
        Self {
            node: node.trim_start_matches('/').into(),
            state: Arc::new(Mutex::new(state)),
            publisher,
        }
    }

    /// Says which hardware this node stands for.
    pub fn set_hardware(&self, hardware_id: impl Into<String>) {
        self.state().hardware_id = hardware_id.into();
    }

    /// Sets the state of `part`, in words, until it is set again.
    pub fn set(&self, part: &str, level: Level, message: impl Into<String>) {
        let state = (level, message.into());
        self.state().parts.insert(part.into(), state);
    }

    pub(crate) fn publish(&self, reports: Vec<Report>) {
        let mut state = self.state();
        let (level, message, values) = state.links.judge(&reports, Instant::now());
        let hardware_id = &state.hardware_id;
        let mut status = vec![self.status("links", level, &message, values, hardware_id)];
        for (part, (level, message)) in &state.parts {
            status.push(self.status(part, *level, message, Vec::new(), hardware_id));
        }
        drop(state);
        let mut message = DiagnosticArray {
            status,
            ..Default::default()
        };
        message.header.stamp = clock::now();
        self.publisher.send(message);
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn status(
        &self,
        part: &str,
        level: Level,
        message: &str,
        values: Vec<KeyValue>,
        hardware_id: &str,
    ) -> DiagnosticStatus {
        DiagnosticStatus {
            level: match level {
                Level::Ok => DiagnosticStatus::OK,
                Level::Warn => DiagnosticStatus::WARN,
                Level::Error => DiagnosticStatus::ERROR,
            },
            name: format!("{}: {part}", self.node),
            message: message.into(),
            hardware_id: hardware_id.into(),
            values,
        }
    }
}
