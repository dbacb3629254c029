//! Which end of the range to go to first in a scan that ends once its answer is sure: how far and how long the wrist turns until then
//! with the nearer end first, as `view_capture` does, with the farther end first, and with an oracle that always knows the better
//! of the two orders. The baseline is the better of two scans with the same order: what the oracle gains beyond it is not chance.
//!
//! `SCANS=150 cargo test --release --workspace --test direction -- --nocapture` measures. `SEED` is the first scan's.
#![allow(clippy::unwrap_used)]

mod common;

use classifier::Model;
use common::{asked, held, mean, model};
use icp_registration::{Parameters, Registrar};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use roi_crop::{Cropper, Frame};
use sim_objects::ObjectClass;
use sim_scan::{Setup, Shot, View, capture_shots};

const FIRST_SEED: u64 = 95_000;
const EXPOSURE_S: f64 = 0.033;
/// wrist_rotator's rate, rad/s, and what it takes to turn round at that rate, s: to rest and up again.
const RATE_RAD_S: f64 = 1.15;
const TURN_ROUND_S: f64 = 2.0 * (1.15 / 5.0 + 5.0 / 80.0);
/// Distances of the wrist from the nearer end, in intervals. From nearer ones view_capture goes through the range at once.
const DISTANCES: [usize; 3] = [2, 4, 6];
/// view_capture's range and spacing: so many intervals, so far apart, rad.
const INTERVALS: usize = 12;
const SPACING_RAD: f64 = 0.1;
/// scan_server's rule.
const SURE: f64 = 0.95;
const TURN_MIN_RAD: f64 = 0.18;

/// What a scan takes until it ends.
#[derive(Debug, Clone, Copy)]
struct Taken {
    turned_rad: f64,
    time_s: f64,
    is_early: bool,
    is_right: bool,
}

/// The places of a range in the order in which a wrist that begins at `place` meets them: to one end, and from there to the
/// other. With each, how far the wrist has turned by then, rad, and how often it has turned round.
fn order(place: usize, to_upper_first: bool) -> Vec<(usize, f64, f64)> {
    let step = |steps: usize| SPACING_RAD * steps as f64;
    let (up, down) = (place..=INTERVALS, (0..=place).rev());
    let ahead: Vec<usize> = if to_upper_first {
        up.collect()
    } else {
        down.collect()
    };
    let first_leg = ahead.len() - 1;
    let behind: Vec<usize> = if to_upper_first {
        (0..place).rev().collect()
    } else {
        (place + 1..=INTERVALS).collect()
    };
    let gone = |at: usize| step(at.abs_diff(place));
    let ahead = ahead.into_iter().map(|at| (at, gone(at), 0.0));
    let turned_round = f64::from(u8::from(first_leg > 0));
    let behind = behind
        .into_iter()
        .map(|at| (at, gone(at) + 2.0 * step(first_leg), turned_round));
    ahead.chain(behind).collect()
}

struct Object {
    class: ObjectClass,
    setup: Setup,
    seed: u64,
}

impl Object {
    fn new(seed: u64) -> Self {
        let (class, setup, _) = held(seed);
        Self { class, setup, seed }
    }

    /// The view from each place of the range, with noise of its own.
    fn views(&self, noise: u64) -> Vec<View> {
        let from_rad = self.setup.wrist_angles_rad[0];
        let shot = |place: usize| Shot {
            turn_rad: RATE_RAD_S * EXPOSURE_S,
            ..Shot::at_rest(from_rad + SPACING_RAD * place as f64)
        };
        let shots: Vec<Shot> = (0..=INTERVALS).map(shot).collect();
        let mut random = Pcg64Mcg::seed_from_u64(self.seed * 16 + noise);
        capture_shots(&self.setup, &shots, &mut random).unwrap()
    }

    fn scan(
        &self,
        views: &[View],
        order: &[(usize, f64, f64)],
        model: &mut Model,
    ) -> Option<Taken> {
        let mut registrar = Registrar::new(Parameters::default()).unwrap();
        let cropper = Cropper::new(self.setup.crop.clone()).unwrap();
        let (mut least, mut most) = (usize::MAX, 0);
        let mut taken = None;
        for &(place, turned_rad, turned_round) in order {
            let view = &views[place];
            let pose = Some(view.believed_hand_from_camera);
            registrar.add_view(&view.points, pose).ok()?;
            let frame = Frame::Hand { opening_m: None };
            let object = cropper.crop(&registrar.cloud(), frame).unwrap();
            let answer = model.classify(&object.points, &object.up).unwrap();
            (least, most) = (least.min(place), most.max(place));
            let seen_rad = SPACING_RAD * (most - least) as f64;
            let is_known = answer.known && registrar.doubt().is_none();
            let is_early = is_known && answer.probability >= SURE && seen_rad >= TURN_MIN_RAD;
            taken = Some(Taken {
                turned_rad,
                time_s: turned_rad / RATE_RAD_S + turned_round * TURN_ROUND_S,
                is_early,
                is_right: answer.label == self.class.name(),
            });
            if is_early {
                break;
            }
        }
        taken
    }
}

fn better(one: Taken, other: Taken) -> Taken {
    if other.time_s < one.time_s {
        other
    } else {
        one
    }
}

#[test]
fn to_go_to_the_nearer_end_first_is_as_good_as_any() {
    let (scans, first_seed) = asked(4, FIRST_SEED);
    println!("{scans} scans from seed {first_seed}");
    let mut model = model();
    // By distance: nearer end first, farther end first, the better of both, the better of two of the same order.
    let mut rows: [[Vec<Taken>; 4]; DISTANCES.len()] = Default::default();
    for seed in (first_seed..).take(scans) {
        let object = Object::new(seed);
        let noises = [0, 1].map(|noise| object.views(noise));
        for (distance, row) in DISTANCES.iter().zip(&mut rows) {
            let mut scan = |views: &[View], to_upper_first: bool| {
                object.scan(views, &order(*distance, to_upper_first), &mut model)
            };
            let [one, other] = &noises;
            let found = [(one, false), (other, false), (one, true), (other, true)];
            let found = found.map(|(views, to_upper_first)| scan(views, to_upper_first));
            let [Some(near), Some(near_again), Some(far), Some(far_again)] = found else {
                println!("seed {seed}: ended by registration");
                continue;
            };
            row[0].extend([near, near_again]);
            row[1].extend([far, far_again]);
            row[2].extend([better(near, far_again), better(near_again, far)]);
            row[3].extend([better(near, near_again), better(far, far_again)]);
        }
    }
    for (distance, row) in DISTANCES.iter().zip(&rows) {
        println!("nearer end {:.1} rad away:", SPACING_RAD * *distance as f64);
        let names = [
            "nearer end first",
            "farther end first",
            "better of both",
            "better of two",
        ];
        for (name, all) in names.iter().zip(row) {
            let of = |figure: fn(&Taken) -> f64| mean(&all.iter().map(figure).collect::<Vec<_>>());
            let ((rad, rad_ci), (time_s, time_ci)) = (of(|t| t.turned_rad), of(|t| t.time_s));
            let (right, early) = (
                of(|t| f64::from(t.is_right)).0,
                of(|t| f64::from(t.is_early)).0,
            );
            println!(
                "  {name:18} {rad:.2} ± {rad_ci:.2} rad, {time_s:.2} ± {time_ci:.2} s, sure {early:.3}, right {right:.3}"
            );
        }
        let saved: Vec<f64> = row[0]
            .iter()
            .zip(&row[1])
            .map(|(near, far)| near.time_s - far.time_s)
            .collect();
        let (saved_s, saved_ci) = mean(&saved);
        println!("  the farther end first saves {saved_s:.2} ± {saved_ci:.2} s");
        assert!(saved_s - 2.0 * saved_ci < 0.0, "{saved:?}");
    }
}
