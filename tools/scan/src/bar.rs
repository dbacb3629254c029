//! How the scan goes, on a terminal; elsewhere nothing is shown.

use indicatif::{ProgressBar, ProgressStyle};
use msg::deformable_cobot::ScanObjectFeedback;
use std::time::Duration;

/// Shows a scan to its user.
pub trait Viewer {
    /// How it goes.
    fn show(&self, report: &ScanObjectFeedback);
    /// These words instead.
    fn say(&self, words: &'static str);
}

/// A line that changes with the scan.
pub struct Bar(ProgressBar);

impl Default for Bar {
    /// Empty so far.
    fn default() -> Self {
        let bar = ProgressBar::new(0);
        let style = ProgressStyle::with_template("{bar:24} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
}

impl Bar {
    /// Removes the line.
    pub fn clear(&self) {
        self.0.finish_and_clear();
    }
}

impl Viewer for Bar {
    fn show(&self, report: &ScanObjectFeedback) {
        self.0.set_length(u64::from(report.count));
        self.0.set_position(u64::from(views_taken(report)));
        self.0.set_message(line(report));
    }

    fn say(&self, words: &'static str) {
        self.0.set_message(words);
    }
}

/// Views that are over.
pub fn views_taken(report: &ScanObjectFeedback) -> u32 {
    let is_over = !matches!(&report.state[..], "turning" | "looking");
    match is_over {
        true => report.view,
        false => report.view.saturating_sub(1),
    }
}

/// A report in words.
pub fn line(report: &ScanObjectFeedback) -> String {
    let mut line = format!("view {} of {}: {}", report.view, report.count, report.state);
    if report.state == "turning" && report.wrist_angle.is_finite() {
        line += &format!(", at {:.0}°", report.wrist_angle.to_degrees());
    }
    match &report.label[..] {
        "" if report.view_count > 0 => line += "; so far an empty hand",
        "" => {}
        label => line += &format!("; so far {label}, {:.0} %", 100.0 * report.probability),
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_where_the_wrist_is_and_what_is_known() {
        let mut report = ScanObjectFeedback {
            state: "turning".into(),
            view: 2,
            count: 3,
            wrist_angle: 0.5,
            ..Default::default()
        };
        assert_eq!(line(&report), "view 2 of 3: turning, at 29°");
        report.view_count = 1;
        report.wrist_angle = f64::NAN;
        assert_eq!(line(&report), "view 2 of 3: turning; so far an empty hand");
        report.label = "tiny-ball".into();
        report.probability = 0.914;
        assert_eq!(
            line(&report),
            "view 2 of 3: turning; so far tiny-ball, 91 %"
        );
    }
}
