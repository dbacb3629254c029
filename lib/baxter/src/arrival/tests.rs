#![allow(clippy::unwrap_used)]
use super::*;

fn arrival() -> Arrival {
    Arrival::new(0.6, 0.0087, 0.02, Duration::from_millis(100))
}

fn sample(stamp_ms: u64, angle_rad: f64, velocity_rad_s: impl Into<Option<f64>>) -> JointSample {
    let stamp = Duration::from_millis(1_000_000 + stamp_ms);
    JointSample {
        angle_rad,
        velocity_rad_s: velocity_rad_s.into(),
        stamp,
    }
}

#[test]
fn arrives_after_the_dwell_and_tells_since_when() {
    let mut arrival = arrival();
    assert_eq!(arrival.observe(sample(0, 0.5, 0.0)), None, "far");
    assert_eq!(arrival.observe(sample(10, 0.6, 0.5)), None, "fast");
    for stamp_ms in (20..120).step_by(10) {
        assert_eq!(
            arrival.observe(sample(stamp_ms, 0.6, 0.0)),
            None,
            "too short"
        );
    }
    let arrived = arrival.observe(sample(120, 0.601, 0.0)).unwrap();
    assert_eq!(arrived.at_rest, sample(20, 0.0, 0.0).stamp);
    assert_eq!(arrived.angle_rad, 0.601);
}

#[test]
fn a_shove_during_the_dwell_starts_it_anew() {
    let mut arrival = arrival();
    arrival.observe(sample(0, 0.6, 0.0));
    arrival.observe(sample(90, 0.62, 0.1));
    assert_eq!(arrival.observe(sample(110, 0.6, 0.0)), None);
    assert!(arrival.observe(sample(210, 0.6, 0.0)).is_some());
}

#[test]
fn one_sample_read_again_and_again_is_no_rest() {
    let mut arrival = arrival();
    for _ in 0..100 {
        assert_eq!(arrival.observe(sample(0, 0.6, 0.0)), None);
    }
}

#[test]
fn without_velocities_two_angles_tell() {
    let mut arrival = arrival();
    for step in 0..40_u32 {
        let creeping = 0.595 + 0.0003 * f64::from(step);
        let arrived = arrival.observe(sample(u64::from(10 * step), creeping, None));
        assert_eq!(arrived, None, "0.03 rad/s is too fast");
    }
    for stamp_ms in (400..500).step_by(10) {
        assert_eq!(arrival.observe(sample(stamp_ms, 0.6067, None)), None);
    }
    assert!(arrival.observe(sample(500, 0.6067, None)).is_some());
}

#[test]
fn stamps_that_jump_back_start_the_dwell_anew() {
    let mut arrival = arrival();
    arrival.observe(sample(500, 0.6, 0.0));
    assert_eq!(arrival.observe(sample(0, 0.6, 0.0)), None);
    assert_eq!(arrival.observe(sample(60, 0.6, 0.0)), None);
    assert_eq!(arrival.observe(sample(100, 0.6, 0.0)), None);
    assert!(arrival.observe(sample(160, 0.6, 0.0)).is_some());
}

#[test]
fn rest_may_be_anywhere_but_must_be_rest() {
    let mut arrival = Arrival::anywhere(0.02, Duration::from_millis(100));
    assert_eq!(arrival.observe(sample(0, -2.5, 0.5)), None, "fast");
    assert_eq!(arrival.observe(sample(10, f64::NAN, 0.0)), None, "nowhere");
    assert_eq!(arrival.observe(sample(20, -2.6, 0.0)), None, "too short");
    assert_eq!(
        arrival.observe(sample(120, -2.6, 0.0)).unwrap().angle_rad,
        -2.6
    );
}

#[test]
fn not_a_number_is_nowhere() {
    let mut arrival = arrival();
    for stamp_ms in (0..500).step_by(10) {
        assert_eq!(arrival.observe(sample(stamp_ms, f64::NAN, 0.0)), None);
        assert_eq!(arrival.observe(sample(stamp_ms + 5, 0.6, f64::NAN)), None);
    }
}
