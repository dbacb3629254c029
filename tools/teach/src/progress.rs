//! One bar for all that teaching does, from the recording to the running classifier.

use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use msg::deformable_cobot::ScanObjectFeedback;
use record_object::Screen;
use scan::bar::{Viewer, line, views_taken};

/// Steps of the bar for a second that is expected.
const STEPS_PER_S: f64 = 1000.0;
/// From this share of a part on, its own pace says how long it takes.
const OWN_PACE_FROM: f64 = 0.1;

/// What is done, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The robot looks at the object.
    Record,
    /// Recorded views are put together.
    Register,
    /// From points to a mesh.
    Mesh,
    /// Dents.
    Dent,
    /// Simulated views.
    Look,
    /// The layers are fitted.
    Adapt,
    /// On held-out views, and writing.
    Measure,
    /// The classifier takes the model.
    Load,
    /// Simulated views of what a model knows, for its features.
    Known,
    /// The same of strangers.
    Strangers,
}

impl Part {
    const fn words(self) -> &'static str {
        match self {
            Self::Record => "recording it",
            Self::Register => "putting the views together",
            Self::Mesh => "making a mesh of the scan",
            Self::Dent => "denting it",
            Self::Look => "looking at it",
            Self::Adapt => "adapting the model",
            Self::Measure => "measuring it",
            Self::Load => "loading the model",
            Self::Known => "looking at what it knows",
            Self::Strangers => "looking at strangers",
        }
    }

    /// How long it takes with the defaults on two idle cores, s. Measured; only their ratios matter once a part is over.
    const fn usual_s(self) -> f64 {
        match self {
            Self::Record | Self::Look => 10.0,
            Self::Register | Self::Mesh => 3.0,
            Self::Dent | Self::Adapt => 2.0,
            Self::Measure | Self::Load => 1.0,
            Self::Known => 160.0,
            Self::Strangers => 60.0,
        }
    }

    /// Whether its pace tells that of the others. A mesh may be there already.
    fn tells_pace(self) -> bool {
        matches!(self, Self::Dent | Self::Look | Self::Adapt)
    }

    /// Whether it is this computer's work.
    fn is_computed(self) -> bool {
        !matches!(self, Self::Record | Self::Load)
    }
}

/// A bar on a terminal; elsewhere a line for each part of the work.
pub struct Progress {
    bar: ProgressBar,
    on_terminal: bool,
    state: Mutex<State>,
}

/// How far it is.
struct State {
    parts: Vec<Part>,
    /// Index of the part under way; `None` before the first one.
    at: Option<usize>,
    began: Instant,
    done: usize,
    steps: usize,
    /// What was expected of computed parts, and what they took, s.
    computed: [f64; 2],
    /// What happens within the part.
    detail: String,
}

impl State {
    fn new(parts: &[Part]) -> Self {
        Self {
            parts: parts.to_vec(),
            at: None,
            began: Instant::now(),
            done: 0,
            steps: 1,
            computed: [0.0; 2],
            detail: String::new(),
        }
    }

    fn part(&self) -> Option<Part> {
        self.parts.get(self.at?).copied()
    }

    /// Ends the part under way after so many seconds, and begins another one.
    fn begin(&mut self, part: Part, steps: usize, took_s: f64) {
        if let Some(part) = self.part().filter(|part| part.tells_pace()) {
            self.computed[0] += part.usual_s();
            self.computed[1] += took_s;
        }
        self.at = self.parts.iter().position(|&other| other == part);
        (self.done, self.steps) = (0, steps.max(1));
        self.began = Instant::now();
        self.detail.clear();
    }

    fn share_done(&self) -> f64 {
        (self.done as f64 / self.steps as f64).min(1.0)
    }

    /// What of all parts is over, in seconds that were expected.
    fn over_s(&self) -> f64 {
        let before = &self.parts[..self.at.unwrap_or(0)];
        let before: f64 = before.iter().map(|part| part.usual_s()).sum();
        before + self.part().map_or(0.0, |part| part.usual_s()) * self.share_done()
    }

    /// How long it takes from now on, if the part under way has taken so long.
    fn left_s(&self, spent_s: f64) -> f64 {
        let [expected_s, took_s] = self.computed;
        let pace = if expected_s > 0.0 {
            took_s / expected_s
        } else {
            1.0
        };
        let left_of = |part: Part| match part.is_computed() {
            true => part.usual_s() * pace,
            false => part.usual_s(),
        };
        let done = self.share_done();
        let now = match self.part() {
            Some(_) if done >= OWN_PACE_FROM => spent_s * (1.0 - done) / done,
            Some(part) => (left_of(part) - spent_s).max(0.0),
            None => 0.0,
        };
        let after = self.at.map_or(0, |at| at + 1);
        now + self.parts[after..]
            .iter()
            .map(|&part| left_of(part))
            .sum::<f64>()
    }
}

impl Progress {
    /// Of these parts, in their order.
    pub fn new(parts: &[Part]) -> Self {
        let all_s: f64 = parts.iter().map(|part| part.usual_s()).sum();
        let on_terminal = std::io::stderr().is_terminal();
        let bar = ProgressBar::new((STEPS_PER_S * all_s) as u64);
        if let Ok(style) = ProgressStyle::with_template("[{bar:20}] {percent:>3} % {wide_msg}") {
            bar.set_style(style);
        }
        Self {
            bar,
            on_terminal,
            state: Mutex::new(State::new(parts)),
        }
    }

    /// Says what is done now, in so many steps.
    pub fn begin(&self, part: Part, steps: usize) {
        let mut state = self.state();
        let took_s = state.began.elapsed().as_secs_f64();
        state.begin(part, steps, took_s);
        if !self.on_terminal {
            program::note(format_args!(
                "{}, {}",
                part.words(),
                left(state.left_s(0.0))
            ));
        }
        self.draw(&state);
    }

    /// One step is done.
    pub fn step(&self) {
        let mut state = self.state();
        state.done += 1;
        self.draw(&state);
    }

    /// Says a line that stays.
    pub fn note(&self, line: &str) {
        self.bar.suspend(|| program::note(line));
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }

    fn draw(&self, state: &State) {
        let Some(part) = state.part().filter(|_| self.on_terminal) else {
            return;
        };
        let left_s = state.left_s(state.began.elapsed().as_secs_f64());
        let what = Some(&state.detail[..]).filter(|detail| !detail.is_empty());
        let what = what.unwrap_or(part.words());
        self.bar.set_position((STEPS_PER_S * state.over_s()) as u64);
        // A narrow terminal cuts off the end.
        self.bar.set_message(format!("{}: {what}", left(left_s)));
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What is left, no finer than it is known.
fn left(left_s: f64) -> String {
    match left_s {
        ..2.0 => "almost done".to_owned(),
        ..20.0 => format!("about {left_s:.0} s left"),
        _ => format!("about {:.0} s left", 5.0 * (left_s / 5.0).round()),
    }
}

impl Viewer for Progress {
    fn show(&self, report: &ScanObjectFeedback) {
        let mut state = self.state();
        state.steps = (report.count as usize).max(1);
        state.done = views_taken(report) as usize;
        state.detail = line(report);
        self.draw(&state);
    }

    fn say(&self, words: &'static str) {
        let mut state = self.state();
        words.clone_into(&mut state.detail);
        self.draw(&state);
    }
}

impl Screen for Progress {
    fn begin(&self) {
        Progress::begin(self, Part::Record, 1);
    }

    fn end(&self) {
        self.say("");
    }

    fn note(&self, line: &str) {
        Progress::note(self, line);
    }
}

#[cfg(test)]
mod tests;
