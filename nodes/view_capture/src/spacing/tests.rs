#![allow(clippy::unwrap_used)]
use super::*;

const PLAN: SweepPlan = SweepPlan {
    from_rad: 0.65,
    to_rad: 1.85,
    count: 13,
};
const BACK: SweepPlan = SweepPlan {
    from_rad: 1.85,
    to_rad: 0.65,
    count: 13,
};

/// The angles of the views, where images come each `image_rad`.
fn taken(plan: &SweepPlan, image_rad: f64) -> Vec<(f64, Place)> {
    let mut spacing = Spacing::new(plan);
    let images = (plan.range_rad() / image_rad).ceil() as i32 + 5;
    (0..images)
        .map(|image| (f64::from(image) * image_rad).min(plan.range_rad()))
        .map(|turned_rad| plan.from_rad + plan.direction() * turned_rad)
        .filter_map(|angle_rad| Some((angle_rad, spacing.take(angle_rad)?)))
        .collect()
}

#[test]
fn views_are_evenly_spaced_and_the_last_one_is_known_as_such() {
    for plan in [PLAN, BACK] {
        let views = taken(&plan, 0.038);
        assert_eq!(views.len(), 13);
        assert_eq!(views[0].0, plan.from_rad);
        for (index, (pair, expected)) in views.windows(2).zip(1..).enumerate() {
            let gap_rad = (pair[1].0 - pair[0].0).abs();
            assert!((0.06..0.14).contains(&gap_rad), "{index}: {gap_rad}");
            assert_eq!(pair[1].1.index, expected);
        }
        let (last_rad, last) = views[12];
        assert!(last.is_last && (last_rad - plan.to_rad).abs() <= END_RAD);
        assert_eq!(views.iter().filter(|(_, place)| place.is_last).count(), 1);
    }
}

#[test]
fn a_slow_camera_leaves_views_out_evenly() {
    // The images at 0, 0.17, ... 1.19 rad, of which the last counts as the end of the range.
    let views = taken(&PLAN, 0.17);
    assert_eq!(views.len(), 8);
    assert!(views.windows(2).all(|pair| pair[1].0 - pair[0].0 < 0.2));
    assert!(views.last().unwrap().1.is_last);
}

#[test]
fn a_wrist_that_stands_or_is_nowhere_gives_one_view() {
    let mut spacing = Spacing::new(&PLAN);
    assert_eq!(spacing.take(f64::NAN), None);
    assert!(spacing.take(0.66).is_some());
    assert!((0..100).all(|_| spacing.take(0.66).is_none()));
    assert_eq!(spacing.taken(), 1);
}

#[test]
fn a_sweep_that_is_no_wider_than_the_ramp_has_one_view() {
    let plan = SweepPlan {
        from_rad: 1.0,
        to_rad: 1.01,
        count: 1,
    };
    let mut spacing = Spacing::new(&plan);
    let is_last = true;
    assert_eq!(spacing.take(1.0), Some(Place { index: 0, is_last }));
    assert_eq!(spacing.take(1.01), None);
}

#[test]
fn a_wrist_within_the_range_looks_on_its_way_to_the_beginning_and_at_no_place_twice() {
    for plan in [PLAN, BACK] {
        let mut spacing = Spacing::from_within(&plan);
        let angle_rad = |turned_rad: f64| plan.from_rad + plan.direction() * turned_rad;
        let turned_rad =
            |image: i32, from_rad: f64, by_rad: f64| from_rad + by_rad * f64::from(image);
        let approach = (0..=15).map(|image| turned_rad(image, 0.61, -0.04).max(0.0));
        let on_the_way: Vec<f64> = approach
            .filter(|turned_rad| spacing.take(angle_rad(*turned_rad)).is_some())
            .collect();
        assert_eq!(on_the_way.first(), Some(&0.61));
        assert_eq!(on_the_way.len(), 7, "{on_the_way:?}");
        spacing.begin_range();
        let range = (0..=31).map(|image| turned_rad(image, 0.0, 0.04).min(plan.range_rad()));
        let then: Vec<(f64, Place)> = range
            .filter_map(|turned_rad| Some((turned_rad, spacing.take(angle_rad(turned_rad))?)))
            .collect();
        assert!(
            then.iter().all(|(turned_rad, _)| *turned_rad > 0.65),
            "{then:?}"
        );
        assert_eq!(spacing.taken(), 13, "{on_the_way:?}, {then:?}");
        let is_last: Vec<bool> = then.iter().map(|(_, place)| place.is_last).collect();
        assert_eq!(is_last, [false, false, false, false, false, true]);
    }
}
