#![allow(clippy::unwrap_used)]
use super::*;
use nalgebra::Vector3;

const S: i64 = 1_000_000_000;

fn turned(angle_rad: f64) -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.1, 0.0, 0.0), Vector3::z() * angle_rad)
}

fn robot() -> TransformBuffer {
    let mut buffer = TransformBuffer::default();
    for i in 0..=10 {
        buffer.insert("/base", "hand", i * S / 10, turned(0.1 * i as f64), false);
    }
    buffer.insert(
        "base",
        "head",
        0,
        Isometry3::translation(0.0, 0.0, 0.7),
        true,
    );
    buffer.insert("head", "camera", 0, Isometry3::rotation(Vector3::x()), true);
    buffer
}

#[test]
fn chains_are_followed_and_interpolated() {
    let hand_from_camera = robot().lookup("hand", "/camera", S / 4).unwrap();
    let expected = turned(0.25).inverse()
        * Isometry3::translation(0.0, 0.0, 0.7)
        * Isometry3::rotation(Vector3::x());
    assert!(
        (hand_from_camera.inverse() * expected)
            .translation
            .vector
            .norm()
            < 1e-9
    );
    assert!(hand_from_camera.rotation.angle_to(&expected.rotation) < 1e-9);
    let back = robot().lookup("camera", "hand", S / 4).unwrap();
    assert!((back * hand_from_camera).translation.vector.norm() < 1e-9);
}

#[test]
fn what_is_above_the_common_ancestor_need_not_be_known() {
    let mut buffer = robot();
    buffer.insert("world", "base", S / 2, Isometry3::identity(), false);
    assert!(buffer.lookup("base", "hand", S / 4).is_ok());
    assert!(buffer.lookup("hand", "camera", S).is_ok());
    assert!(matches!(
        buffer.lookup("world", "hand", S / 4),
        Err(TransformError::TooOld { .. })
    ));
}

#[test]
fn what_is_missing_is_said() {
    let mut buffer = robot();
    assert_eq!(
        buffer.lookup("hand", "nose", 0),
        Err(TransformError::UnknownFrame("nose".into()))
    );
    assert!(matches!(
        buffer.lookup("hand", "base", -S),
        Err(TransformError::TooOld { .. })
    ));
    assert!(matches!(
        buffer.lookup("hand", "base", 2 * S),
        Err(TransformError::NotYet { .. })
    ));
    buffer.insert("moon", "rock", 0, Isometry3::identity(), true);
    assert!(matches!(
        buffer.lookup("hand", "rock", 0),
        Err(TransformError::Disconnected { .. })
    ));
    buffer.insert("rock", "moon", 0, Isometry3::identity(), true);
    assert!(buffer.lookup("hand", "rock", 0).is_err(), "a loop ends");
}

#[test]
fn time_that_went_back_forgets_the_other_past() {
    let mut buffer = robot();
    buffer.insert("base", "hand", 100 * S, turned(0.0), false);
    buffer.insert("base", "hand", S, turned(1.0), false);
    assert!(buffer.lookup("base", "hand", 50 * S).is_err());
    buffer.forget_motion();
    assert!(
        buffer.lookup("head", "camera", 77 * S).is_ok(),
        "fixed transforms stay"
    );
    assert!(buffer.lookup("base", "hand", S).is_err());
}

#[test]
fn memory_is_bounded() {
    let mut buffer = TransformBuffer::default();
    for i in 0..10_000 {
        buffer.insert("base", "hand", i * S / 100, turned(0.0), false);
    }
    assert!(buffer.frames["hand"].samples.len() <= 6001);
}
