//! What an exposure of 33 ms does to the cloud of a wrist that turns, with nothing else wrong: no mount, joint or clock error.
//!
//! `SCANS=100 cargo test --release --workspace --test blur -- --nocapture` measures. `SEED` is the first scan's.
#![allow(clippy::unwrap_used)]

mod common;

use cloud::Tree;
use common::{asked, held};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sim_camera::OBJECT_BOTTOM_Z_M;
use sim_scan::{Setup, Shot, capture_shots};

const EXPOSURE_S: f64 = 0.033;
/// At rest, the rate of a sweep, and two that `view_capture` refuses.
const RATES_RAD_S: [f64; 4] = [0.0, 1.15, 2.3, 4.0];
/// Points of the true surface: less than half a millimetre apart.
const SURFACE_POINTS: usize = 200_000;

/// A view of a turning object: distances of its points on the object from the true surface, mm.
fn distances_mm(setup: &Setup, surface: &Tree, rate_rad_s: f64, seed: u64) -> Vec<f64> {
    let wrist_rad = setup.wrist_angles_rad[0];
    let shot = Shot {
        turn_rad: rate_rad_s * EXPOSURE_S,
        ..Shot::at_rest(wrist_rad)
    };
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let views = capture_shots(setup, &[shot], &mut random).unwrap();
    let hand_from_camera = setup.camera_from_hand(wrist_rad).inverse();
    cloud::transformed(&hand_from_camera, &views[0].points)
        .iter()
        .filter(|point| point.z > OBJECT_BOTTOM_Z_M)
        .map(|point| 1e3 * f64::from(surface.nearest(point).distance_sq).sqrt())
        .collect()
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn blur_at_the_rate_of_a_sweep_is_less_than_the_noise() {
    let (scans, first_seed) = asked(8, 90_000);
    println!("{scans} scans from seed {first_seed}");
    let mut by_rate = RATES_RAD_S.map(|_| (vec![], 0.0));
    for seed in (first_seed..).take(scans) {
        let (_, setup, mut random) = held(seed);
        let points = setup.scene.hand.surface_points(SURFACE_POINTS, &mut random);
        let surface = Tree::new(&points).unwrap();
        for (rate_rad_s, (all, count)) in RATES_RAD_S.iter().zip(&mut by_rate) {
            let distances = distances_mm(&setup, &surface, *rate_rad_s, seed);
            *count += distances.len() as f64 / scans as f64;
            all.push(rms(&distances));
        }
    }
    let [at_rest, swept, ..] = by_rate.each_ref().map(|(all, _)| rms(all));
    for (rate_rad_s, (all, count)) in RATES_RAD_S.iter().zip(&by_rate) {
        println!(
            "{rate_rad_s:.2} rad/s: {:.2} mm RMS from the true surface, {count:.0} points a view",
            rms(all)
        );
    }
    let added_mm = (swept * swept - at_rest * at_rest).max(0.0).sqrt();
    assert!(at_rest > 0.1 && added_mm < at_rest, "{at_rest} {swept}");
}
