use super::*;

fn sample(stamp_ms: u64, angle_rad: f64) -> JointSample {
    JointSample {
        angle_rad,
        velocity_rad_s: None,
        stamp: Duration::from_millis(stamp_ms),
    }
}

fn at(track: &WristTrack, moment_ms: u64) -> Option<f64> {
    track.at(Duration::from_millis(moment_ms))
}

#[test]
fn angles_are_interpolated_between_joint_states_and_not_beyond() {
    let mut track = WristTrack::default();
    for (stamp_ms, angle_rad) in [(1000, 0.0), (1010, 0.01), (1030, 0.05), (1020, 9.0)] {
        track.note(&sample(stamp_ms, angle_rad), None);
    }
    assert_eq!(at(&track, 1000), Some(0.0));
    assert!(at(&track, 1020).is_some_and(|angle_rad| (angle_rad - 0.03).abs() < 1e-12));
    assert_eq!((at(&track, 999), at(&track, 1031)), (None, None));
    assert!((track.rate_at(Duration::from_millis(1030)) - 0.0).abs() < 1e-12);
    track.note(&sample(1040, 0.07), None);
    assert!((track.rate_at(Duration::from_millis(1040)) - 1.75).abs() < 1e-9);
    assert!(track.reaches(Duration::from_millis(1030)));
    assert!(!track.reaches(Duration::from_millis(1041)));
}

#[test]
fn what_is_old_or_of_another_past_is_forgotten() {
    let mut track = WristTrack::default();
    (0..1000).for_each(|index| track.note(&sample(10 * index, 1.0), None));
    assert!(track.samples.len() <= 301);
    assert_eq!(at(&track, 100), None);
    track.note(&sample(50, 2.0), None);
    track.note(&sample(60, f64::NAN), None);
    assert_eq!((at(&track, 50), track.samples.len()), (Some(2.0), 1));
    assert_eq!(track.clock_steps().count, 1);
}

#[test]
fn a_clock_that_is_set_is_told_from_messages_that_are_held_up() {
    let mut track = WristTrack::default();
    let begin = Instant::now();
    let note = |track: &mut WristTrack, stamp_ms, received_ms| {
        let received = begin + Duration::from_millis(received_ms);
        track.note(&sample(stamp_ms, 0.0), Some(received));
        (track.clock_steps().count, track.clock_steps().last_s)
    };
    for index in 0..10 {
        assert_eq!(note(&mut track, 1000 + 10 * index, 10 * index).0, 0);
    }
    // Nothing comes for 0.4 s, then all at once; nothing comes for 0.4 s, and is lost.
    for index in 10..50 {
        assert_eq!(note(&mut track, 1000 + 10 * index, 490).0, 0);
    }
    assert_eq!(note(&mut track, 1890, 890).0, 0);
    let (count, last_s) = note(&mut track, 2400, 900);
    assert!(count == 1 && (last_s - 0.5).abs() < 1e-9);
    let (count, last_s) = note(&mut track, 1910, 910);
    assert!(count == 2 && (last_s + 0.49).abs() < 1e-9);
    assert_eq!(at(&track, 1910), Some(0.0));
    assert_eq!(at(&track, 2400), None);
}
