//! What is like known features, and what is not.
#![allow(clippy::unwrap_used)]

use adaptation::{Familiar, FeatureRows};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Rows of two features about a centre, the second of them twice the first and a little more.
fn line(centre: [f32; 2], seed: u64) -> FeatureRows {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut rows = FeatureRows::new(2);
    for _ in 0..500 {
        let along: f32 = random.random_range(-1.0..1.0);
        let aside: f32 = random.random_range(-0.01..0.01);
        rows.push(&[centre[0] + along, centre[1] + 2.0 * along + aside]);
    }
    rows
}

fn one(row: [f32; 2]) -> FeatureRows {
    let mut rows = FeatureRows::new(2);
    rows.push(&row);
    rows
}

#[test]
fn what_is_as_near_but_varies_otherwise_is_less_familiar() {
    let seed = 4;
    println!("seed {seed}");
    let known = [line([0.0, 0.0], seed), line([10.0, 0.0], seed + 1)];
    let familiar = Familiar::of(&known).unwrap();
    let along = familiar.score(&one([0.4, 0.8]));
    let across = familiar.score(&one([0.8, -0.4]));
    assert!(along > -2.0 && across < -5.0, "{along} and {across}");
    assert!(familiar.score(&one([10.4, 0.8])) > -2.0);
    let mut both = one([0.4, 0.8]);
    both.push(&[0.8, -0.4]);
    assert!((familiar.score(&both) - 0.5 * (along + across)).abs() < 1e-9);
}

#[test]
fn nothing_is_familiar_without_clouds_and_a_constant_feature_does_no_harm() {
    assert_eq!(Familiar::of(&[] as &[FeatureRows]), None);
    assert_eq!(Familiar::of(&[FeatureRows::new(2)]), None);
    let mut rows = FeatureRows::new(2);
    (0..9).for_each(|k| rows.push(&[k as f32, 1.0]));
    let familiar = Familiar::of(&[rows]).unwrap();
    assert!(familiar.score(&one([4.0, 1.0])) > familiar.score(&one([4.0, 2.0])));
    assert!(familiar.score(&one([4.0, 2.0])).is_finite());
    assert_eq!(familiar.score(&FeatureRows::new(2)), f64::NEG_INFINITY);
}
