//! The text above the hand.

/// A line and its colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Words {
    /// The text.
    pub text: String,
    /// Red, green and blue, 0 to 1.
    pub colour: [f32; 3],
}

const KNOWN: [f32; 3] = [0.35, 1.0, 0.45];
const UNKNOWN: [f32; 3] = [1.0, 0.65, 0.2];
const PLAIN: [f32; 3] = [0.85, 0.85, 0.85];

/// The text of an answer. An empty label means an empty hand. If the object is not `known`, the part of `reason` before its
/// first comma, colon, semicolon or bracket becomes a second line.
pub fn answer_words(label: &str, probability: f64, known: bool, reason: &str) -> Words {
    let percent = 100.0 * probability;
    let (text, colour) = match (label, known) {
        ("", _) => ("empty hand".into(), PLAIN),
        (label, true) => (format!("{label}  {percent:.1} %  known"), KNOWN),
        (label, false) => {
            let brief = reason
                .split([',', ':', ';', '('])
                .next()
                .unwrap_or_default();
            let text = format!(
                "unknown, most like {label}  {percent:.1} %\n{}",
                brief.trim()
            );
            (text.trim_end().to_owned(), UNKNOWN)
        }
    };
    Words { text, colour }
}

/// The text about a scan's progress, from the state and the counts of its report; `None` once it has ended.
pub fn progress_words(state: &str, view: u32, count: u32) -> Option<Words> {
    let text = match state {
        "turning" | "looking" => format!("view {view} of {count}: {state}"),
        "classifying" => format!("{count} views: classifying"),
        _ => return None,
    };
    Some(Words {
        text,
        colour: PLAIN,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_unknown_and_nothing_are_told_apart() {
        assert_eq!(
            answer_words("tiny-ball", 0.9876, true, "").text,
            "tiny-ball  98.8 %  known"
        );
        let unknown = answer_words("tiny-ball", 0.5, false, "the mount is off: by 3 mm");
        assert_eq!(
            unknown.text,
            "unknown, most like tiny-ball  50.0 %\nthe mount is off"
        );
        assert_ne!(unknown.colour, KNOWN);
        assert_eq!(answer_words("", 0.0, false, "").text, "empty hand");
    }

    #[test]
    fn a_scan_that_has_ended_says_nothing() {
        let words = |state| progress_words(state, 2, 3).map(|words| words.text);
        assert_eq!(words("turning").as_deref(), Some("view 2 of 3: turning"));
        assert_eq!(
            words("classifying").as_deref(),
            Some("3 views: classifying")
        );
        assert_eq!(words("done"), None);
        assert_eq!(words(""), None);
    }
}
