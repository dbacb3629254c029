#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn the_defaults_are_valid_and_hold_nothing() {
    let parameters = Parameters::default();
    parameters.validate().unwrap();
    assert_eq!(parameters.held(), Held::Nothing);
    assert_eq!(
        (parameters.captures_folder(), parameters.capture_frame()),
        (None, None)
    );
}

#[test]
fn what_is_out_of_range_is_named() {
    let default = Parameters::default;
    let noise_model = NoiseParameters {
        edge_mixing: -1.0,
        ..Default::default()
    };
    for (parameters, name) in [
        (
            Parameters {
                object: "teapot".into(),
                ..default()
            },
            "object is teapot",
        ),
        (
            Parameters {
                squeeze_m: 0.1,
                ..default()
            },
            "squeeze_m is 0.1",
        ),
        (
            Parameters {
                rate_hz: 0.0,
                ..default()
            },
            "rate_hz is 0",
        ),
        (
            Parameters {
                noise_model,
                ..default()
            },
            "edge_mixing is -1",
        ),
    ] {
        let error = parameters.validate().unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    let error = Parameters {
        object: "teapot".into(),
        ..default()
    }
    .validate()
    .unwrap_err();
    assert!(error.to_string().contains("medium-can"), "{error}");
}
