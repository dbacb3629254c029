use super::*;

fn answer(right: &str, said: Option<(&str, bool)>) -> RealAnswer {
    RealAnswer {
        name: "a".to_owned(),
        right: right.split(" or ").map(str::to_owned).collect(),
        said: said.map(|(label, known)| Said {
            label: label.to_owned(),
            probability: 1.0,
            known,
            score: 0.0,
            threshold: 0.0,
        }),
    }
}

#[test]
fn only_a_known_answer_can_do_harm() {
    for (right, said, verdict) in [
        (
            "large-cup or unknown",
            Some(("large-cup", true)),
            Verdict::Right,
        ),
        (
            "large-cup or unknown",
            Some(("large-cup", false)),
            Verdict::Right,
        ),
        (
            "large-cup or unknown",
            Some(("small-cup", true)),
            Verdict::KnownWrong,
        ),
        ("unknown", Some(("small-cup", true)), Verdict::KnownWrong),
        ("unknown", None, Verdict::Right),
        (
            "small-cup",
            Some(("small-cup", false)),
            Verdict::RightUnknown,
        ),
        (
            "small-cup",
            Some(("large-cup", false)),
            Verdict::WrongUnknown,
        ),
        ("small-cup", None, Verdict::WrongUnknown),
    ] {
        assert_eq!(answer(right, said).verdict(), verdict, "{right}, {said:?}");
    }
}

#[test]
fn a_notes_line_says_what_is_right() {
    let note = "# cup\n\n- from: there\n- the product should say: large-cup or unknown\n";
    let expected = vec!["large-cup".to_owned(), "unknown".to_owned()];
    assert_eq!(right(note), Some(expected));
    assert_eq!(right("# cup"), None);
}
