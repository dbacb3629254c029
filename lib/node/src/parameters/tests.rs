#![allow(clippy::unwrap_used)]
use super::*;
use serde::Deserialize;

#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Sample {
    radius_m: f64,
}

impl Default for Sample {
    fn default() -> Self {
        Self { radius_m: 0.5 }
    }
}

fn resolve_text(text: &str) -> Result<Sample, ParameterError> {
    resolve(
        "/sample",
        serde_yaml::from_str(text).unwrap(),
        |sample: &Sample| {
            let fine = sample.radius_m > 0.0;
            fine.then_some(())
                .ok_or(format!("radius_m is {}; it must be > 0", sample.radius_m))
        },
    )
}

#[test]
fn defaults_fill_in_and_whole_numbers_serve_as_reals() {
    assert_eq!(resolve_text("{}").unwrap(), Sample::default());
    assert_eq!(
        resolve_text("radius_m: 2").unwrap(),
        Sample { radius_m: 2.0 }
    );
}

#[test]
fn values_come_back_from_the_wire() {
    let text = "{radius_m: 0.5, big: 5000000000, names: [a, b], deep: {on: true, none: null}}";
    let sent: Value = serde_yaml::from_str(text).unwrap();
    let back = from_wire(to_wire(&sent).unwrap());
    let text = "{radius_m: 0.5, big: 5000000000.0, names: [a, b], deep: {on: true}}";
    assert_eq!(back, serde_yaml::from_str::<Value>(text).unwrap());
}

#[test]
fn private_parameters_are_given_as_arguments() {
    let words = ["_radius_m:=0.1", "__name:=crop", "views:=/views", "--json"];
    let given = given(words.into_iter().map(str::to_owned));
    assert_eq!(given, [("radius_m".to_owned(), "0.1".to_owned())]);
}

#[test]
fn unknown_keys_and_bad_values_are_named() {
    let unknown = resolve_text("raduis_m: 1.0").unwrap_err().to_string();
    assert!(
        unknown.contains("/sample") && unknown.contains("raduis_m"),
        "{unknown}"
    );
    assert!(
        unknown.contains("radius_m"),
        "says what is allowed: {unknown}"
    );
    let range = resolve_text("radius_m: -1.0").unwrap_err().to_string();
    assert!(range.contains("radius_m is -1"), "{range}");
}
