//! The answer in words, and as data.

use msg::deformable_cobot::Classification;
use serde_json::{Map, Value, json};

/// One line for a person.
pub fn to_text(answer: &Classification) -> String {
    let views = match answer.view_count {
        1 => "1 view".into(),
        count => format!("{count} views"),
    };
    let percent = 100.0 * answer.probability;
    match (&answer.label[..], answer.known) {
        ("", _) => format!("the hand is empty, by {views}"),
        (label, true) => format!("{label}, {percent:.1} %, by {views}"),
        (label, false) => format!("unknown, most like {label} ({percent:.1} %), by {views}"),
    }
}

/// All of it that a program may want.
pub fn to_json(answer: &Classification) -> Value {
    json!({
        "scan_id": answer.scan_id,
        "label": answer.label,
        "known": answer.known,
        "probability": answer.probability,
        "probabilities": probabilities(answer),
        "view_count": answer.view_count,
        "point_count": answer.point_count,
        "provider": answer.provider,
        "model_id": answer.model_id,
        "timing_ms": timing_ms(answer),
    })
}

fn probabilities(answer: &Classification) -> Map<String, Value> {
    let labels = answer.labels.iter().cloned();
    let values = answer.probabilities.iter().copied().map(Value::from);
    labels.zip(values).collect()
}

fn timing_ms(answer: &Classification) -> Map<String, Value> {
    let stages = answer.timing.iter();
    let named = stages.map(|stage| {
        (
            stage.stage.clone(),
            Value::from(stage.elapsed.seconds() * 1e3),
        )
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_tell_known_unknown_and_nothing_apart() {
        let mut answer = Classification {
            label: "small-cup".into(),
            known: true,
            probability: 0.9876,
            view_count: 3,
            ..Default::default()
        };
        assert_eq!(to_text(&answer), "small-cup, 98.8 %, by 3 views");
        answer.known = false;
        assert_eq!(
            to_text(&answer),
            "unknown, most like small-cup (98.8 %), by 3 views"
        );
        answer.label.clear();
        answer.view_count = 1;
        assert_eq!(to_text(&answer), "the hand is empty, by 1 view");
    }
}
