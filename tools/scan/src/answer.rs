//! The answer in words, and as data.

use msg::deformable_cobot::Classification;
use serde_json::{Map, Value, json};

/// One line for a person.
pub fn to_text(answer: &Classification) -> String {
    let views = match (answer.view_count, answer.refused_count) {
        (1, _) => "1 view".into(),
        (count, 0) => format!("{count} views"),
        (count, refused) => format!("{} of {count} views", count.saturating_sub(refused)),
    };
    let percent = 100.0 * answer.probability;
    match (&answer.label[..], answer.known) {
        ("", _) => format!("the hand is empty, by {views}"),
        (label, true) => format!("{label}, {percent:.1} %, by {views}"),
        (label, false) => format!(
            "unknown, most like {label} ({percent:.1} %), by {views}: {}",
            answer.reason
        ),
    }
}

/// All of it that a program may want.
pub fn to_json(answer: &Classification) -> Value {
    json!({
        "scan_id": answer.scan_id,
        "label": answer.label,
        "known": answer.known,
        "reason": answer.reason,
        "known_score": answer.known_score,
        "known_threshold": answer.known_threshold,
        "probability": answer.probability,
        "probabilities": probabilities(answer),
        "view_count": answer.view_count,
        "registered_count": answer.registered_count,
        "refused_count": answer.refused_count,
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
        answer.refused_count = 1;
        answer.reason = "it is unlike them".into();
        assert_eq!(
            to_text(&answer),
            "unknown, most like small-cup (98.8 %), by 2 of 3 views: it is unlike them"
        );
        answer.label.clear();
        answer.view_count = 1;
        assert_eq!(to_text(&answer), "the hand is empty, by 1 view");
    }
}
