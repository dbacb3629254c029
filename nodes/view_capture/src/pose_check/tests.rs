use super::*;
use nalgebra::{Translation3, UnitQuaternion};

const IMAGE: ImagePlane = ImagePlane {
    fx: 418.0,
    fy: 418.0,
    cx: 424.0,
    cy: 238.0,
    width: 848.0,
    height: 480.0,
};

fn rules() -> PoseRules {
    crate::Parameters::default().pose_rules()
}

/// A hand that points up before a level camera: right, down and forward of it, m.
fn hand_at(right_m: f64, down_m: f64, forward_m: f64) -> Isometry3<f64> {
    let up_is_minus_y = UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    Isometry3::from_parts(Translation3::new(right_m, down_m, forward_m), up_is_minus_y)
}

fn words(result: Result<(), PoseError>) -> String {
    result.map_or_else(|error| error.to_string(), |()| String::new())
}

#[test]
fn a_gripper_may_lean_15_degrees_and_whatever_it_turns_about_itself() {
    let leaning = |degrees: f64, turn_rad: f64| {
        let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, turn_rad);
        let leaning = UnitQuaternion::from_euler_angles(degrees.to_radians(), 0.0, 0.0);
        Isometry3::from_parts(Translation3::new(0.6, 0.0, 0.4), leaning * turned)
    };
    for turn_rad in [-3.0, 0.0, 1.25] {
        assert_eq!(rules().check_upright(&leaning(14.9, turn_rad)), Ok(()));
        let text = words(rules().check_upright(&leaning(20.0, turn_rad)));
        assert!(
            text.contains("leans 20.0 degrees") && text.contains("5.0 more"),
            "{text}"
        );
    }
    let text = words(rules().check_upright(&leaning(180.0, 0.0)));
    assert!(text.contains("leans 180.0"), "{text}");
}

#[test]
fn the_place_of_the_object_must_be_in_range_and_in_the_image() {
    let check = |hand: Isometry3<f64>| words(rules().check_in_view(&hand, &IMAGE));
    assert_eq!(check(hand_at(0.0, 0.2, 0.4)), "");
    for (hand, expected) in [
        (hand_at(0.0, 0.2, 0.9), "0.20 m too far"),
        (hand_at(0.0, 0.2, 0.15), "0.10 m too near"),
        (hand_at(0.0, 0.2, -0.4), "0.65 m too near"),
        (hand_at(0.8, 0.2, 0.5), "beyond the right edge"),
        (hand_at(-0.8, 0.2, 0.5), "beyond the left edge"),
        (hand_at(0.0, 0.6, 0.5), "beyond the lower edge"),
        (hand_at(0.0, -0.3, 0.5), "beyond the upper edge"),
    ] {
        let text = check(hand);
        assert!(text.contains(expected), "{text} lacks {expected}");
    }
    let text = check(hand_at(0.8, 0.2, 0.5));
    assert!(
        text.contains(&format!("{:.0} pixels", 418.0 * 1.6 - 424.0)),
        "{text}"
    );
}

#[test]
fn a_camera_without_focal_length_is_named() {
    for fx in [0.0, f64::NAN] {
        let image = ImagePlane { fx, ..IMAGE };
        let checked = rules().check_in_view(&hand_at(0.0, 0.2, 0.4), &image);
        assert!(matches!(checked, Err(PoseError::BadCamera { .. })));
    }
}
