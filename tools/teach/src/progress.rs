//! One bar for all that teaching does.

use std::io::IsTerminal;
use std::sync::Mutex;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on a terminal; elsewhere a line for each part of the work.
pub struct Progress {
    bar: ProgressBar,
    on_terminal: bool,
    said: Mutex<&'static str>,
}

impl Progress {
    /// Of so many steps.
    pub fn new(steps: usize) -> Self {
        let bar = ProgressBar::new(steps as u64);
        let template = "{msg:28} [{bar:40}] {percent} % {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self {
            bar,
            on_terminal: std::io::stderr().is_terminal(),
            said: Mutex::new(""),
        }
    }

    /// Says what is done now.
    pub fn say(&self, what: &'static str) {
        let mut said = self
            .said
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        if *said != what && !self.on_terminal {
            program::note(what);
        }
        *said = what;
        self.bar.set_message(what);
    }

    /// One step is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
