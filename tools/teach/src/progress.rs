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
            Self::Record => 25.0,
            Self::Register => 3.0,
            Self::Mesh => 3.0,
            Self::Dent => 3.0,
            Self::Look => 8.0,
            Self::Adapt => 4.0,
            Self::Measure | Self::Load => 1.0,
            Self::Known => 160.0,
            Self::Strangers => 60.0,
        }
    }

    /// Whether it is this computer's work, so that its pace tells that of the others.
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
        if let Some(part) = self.part().filter(|part| part.is_computed()) {
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
        if let Ok(style) = ProgressStyle::with_template("[{bar:30}] {percent:>3} % {msg}") {
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
            let left_s = state.left_s(0.0);
            program::note(format_args!("{}, {}", part.words(), left(left_s)));
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
        let what = match state.detail.is_empty() {
            true => part.words(),
            false => state.detail.as_str(),
        };
        self.bar.set_position((STEPS_PER_S * state.over_s()) as u64);
        self.bar.set_message(format!("{what}, {}", left(left_s)));
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A time that is left, no finer than it is known.
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
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_the_pace_of_what_was_computed() {
        let parts = [Part::Record, Part::Mesh, Part::Dent, Part::Load];
        let mut state = State::new(&parts);
        assert_eq!((state.over_s(), state.left_s(0.0)), (0.0, 32.0));
        state.begin(Part::Record, 4, 0.0);
        assert_eq!(state.left_s(5.0), 20.0 + 7.0);
        state.done = 2;
        assert_eq!((state.over_s(), state.left_s(20.0)), (12.5, 20.0 + 7.0));
        // The robot's time says nothing of the computer's.
        state.begin(Part::Mesh, 1, 50.0);
        assert_eq!(state.left_s(0.0), 7.0);
        state.begin(Part::Dent, 10, 9.0);
        assert_eq!((state.over_s(), state.left_s(0.0)), (28.0, 3.0 * 3.0 + 1.0));
        state.done = 5;
        assert_eq!(state.left_s(4.0), 4.0 + 1.0);
        state.begin(Part::Load, 1, 8.0);
        assert_eq!(state.left_s(7.0), 0.0);
    }

    #[test]
    fn a_time_is_said_no_finer_than_it_is_known() {
        let said = [0.4, 7.3, 43.0].map(left);
        assert_eq!(said, ["almost done", "about 7 s left", "about 45 s left"]);
    }
}
