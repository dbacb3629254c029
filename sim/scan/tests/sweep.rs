//! Scans during one sweep of the wrist beside scans with a rest for each view, over equal range, of the same dented objects:
//! how often right, how far the registered cloud is from the true surface, and how far views are from their true poses.
//!
//! `SCANS=200 cargo test --release --workspace --test sweep -- --nocapture` measures; the few scans of a usual run only notice
//! that something has broken. `SEED` is the first scan's.
#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use classifier::{Answer, Model};
use cloud::Tree;
use common::{asked, held, mean, model};
use icp_registration::{Parameters, Registrar, TimeOffset, TimeOffsets};
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, UnitSphere};
use rand_pcg::Pcg64Mcg;
use roi_crop::{Cropper, Frame};
use sim_camera::OBJECT_BOTTOM_Z_M;
use sim_objects::ObjectClass;
use sim_scan::{Setup, Shot, View, capture_shots};
use view_capture::{ClockDifference, Spacing, SweepPlan};

const FIRST_SEED: u64 = 70_000;
/// Joints between wrist and camera are off by up to this, the same whenever the wrist is at the same angle: 0.25°.
const JOINT_ERROR_RAD: f64 = 0.0044;
/// Largest difference between the clocks of joints and images, s.
const OFFSET_S: f64 = 0.02;
/// Scans in a row with the same clocks: what one tells of their difference, the next one uses, as `view_capture` does.
const LAB_SCANS: u64 = 10;
/// Longest exposure of a D435i at 30 Hz, s.
const EXPOSURE_S: f64 = 0.033;
const IMAGE_PERIOD_S: f64 = 1.0 / 30.0;
/// wrist_rotator's, rad/s and rad/s².
const RATE_RAD_S: f64 = 1.15;
const ACCELERATION_RAD_S2: f64 = 5.0;
const STEP_RAD: f64 = 0.6;
/// Views of a sweep, rad apart.
const SPACING_RAD: f64 = 0.1;
/// Points of the true surface: less than half a millimetre apart.
const SURFACE_POINTS: usize = 200_000;
/// Probabilities at which a scan might end early.
const SURE: [f64; 3] = [0.9, 0.95, 0.99];

#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    right: f64,
    /// Called known, and wrong.
    harmful: f64,
    rms_mm: f64,
    turned_deg: f64,
    shifted_mm: f64,
    refused: f64,
    offset: Option<TimeOffset>,
    /// For each of [`SURE`]: the turn until the first answer that was so sure, rad, and whether all views changed it, or it was wrong.
    early: [Option<Early>; SURE.len()],
}

#[derive(Debug, Clone, Copy)]
struct Early {
    turned_rad: f64,
    changed: bool,
    wrong: bool,
}

/// What is the same for both scans of an object.
struct Bench {
    class: ObjectClass,
    setup: Setup,
    surface: Tree,
    from_rad: f64,
    range_rad: f64,
    offset_s: f64,
    /// The joints' error as the wrist turns.
    joints: [Vector3<f64>; 2],
}

impl Bench {
    fn new(seed: u64, range_rad: f64) -> Self {
        let (class, setup, mut random) = held(seed);
        let surface = setup.scene.hand.surface_points(SURFACE_POINTS, &mut random);
        let direction = |random: &mut Pcg64Mcg| {
            let direction: [f64; 3] = UnitSphere.sample(random);
            Vector3::from(direction)
        };
        Self {
            class,
            surface: Tree::new(&surface).unwrap(),
            from_rad: setup.wrist_angles_rad[0],
            range_rad,
            offset_s: random.random_range(-OFFSET_S..=OFFSET_S),
            joints: [direction(&mut random), direction(&mut random)],
            setup,
        }
    }

    /// The angle and speed of the wrist, so long after the begin of a sweep.
    fn swept(&self, time_s: f64) -> (f64, f64) {
        let ramp_s = RATE_RAD_S / ACCELERATION_RAD_S2;
        let ramp_rad = 0.5 * RATE_RAD_S * ramp_s;
        let lasts_s = (self.range_rad - 2.0 * ramp_rad) / RATE_RAD_S + 2.0 * ramp_s;
        let speeding_up = |time_s: f64| {
            let time_s = time_s.clamp(0.0, ramp_s);
            (
                0.5 * ACCELERATION_RAD_S2 * time_s * time_s,
                ACCELERATION_RAD_S2 * time_s,
            )
        };
        if time_s <= ramp_s {
            let (turned_rad, speed_rad_s) = speeding_up(time_s);
            (self.from_rad + turned_rad, speed_rad_s)
        } else if time_s < lasts_s - ramp_s {
            let turned_rad = ramp_rad + (time_s - ramp_s) * RATE_RAD_S;
            (self.from_rad + turned_rad, RATE_RAD_S)
        } else {
            let (left_rad, speed_rad_s) = speeding_up(lasts_s - time_s);
            (self.from_rad + self.range_rad - left_rad, speed_rad_s)
        }
    }

    /// Views as view_capture takes them while the wrist turns.
    fn sweep(&self) -> Vec<Shot> {
        let plan = SweepPlan {
            from_rad: self.from_rad,
            to_rad: self.from_rad + self.range_rad,
            count: (self.range_rad / SPACING_RAD).round() as u32 + 1,
        };
        let mut spacing = Spacing::new(&plan);
        let mut shots = vec![];
        for image in 0.. {
            let time_s = f64::from(image) * IMAGE_PERIOD_S;
            let (wrist_rad, speed_rad_s) = self.swept(time_s);
            let (believed_rad, _) = self.swept(time_s + self.offset_s);
            let Some(place) = spacing.take(believed_rad) else {
                continue;
            };
            shots.push(Shot {
                wrist_rad,
                turn_rad: speed_rad_s * EXPOSURE_S,
                believed_rad,
            });
            if place.is_last {
                break;
            }
        }
        shots
    }

    /// Views at rest.
    fn steps(&self) -> Vec<Shot> {
        let intervals = (self.range_rad / STEP_RAD).round() as u32;
        let angle_rad =
            |step: u32| self.from_rad + self.range_rad * f64::from(step) / f64::from(intervals);
        (0..=intervals)
            .map(|step| Shot::at_rest(angle_rad(step)))
            .collect()
    }

    fn joint_error(&self, wrist_rad: f64) -> Isometry3<f64> {
        let [one, other] = self.joints;
        let error = (one * wrist_rad.cos() + other * wrist_rad.sin()) / 2.0_f64.sqrt();
        Isometry3::rotation(error * JOINT_ERROR_RAD)
    }

    /// `None` where registration ended the scan, because it took the object for another.
    fn seen(&self, shots: &[Shot], model: &mut Model, seed: u64) -> Option<Seen> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let views = capture_shots(&self.setup, shots, &mut random).unwrap();
        let mut registrar = Registrar::new(Parameters::default()).unwrap();
        let mut seen = Seen::default();
        let mut offsets = TimeOffsets::default();
        let mut hand_from_registered = None;
        let mut poses = 0.0;
        let mut answers = vec![];
        for (
            shot,
            View {
                points,
                believed_hand_from_camera,
            },
        ) in shots.iter().zip(views)
        {
            let believed = self.joint_error(shot.wrist_rad) * believed_hand_from_camera;
            let evidence = registrar.add_view(&points, Some(believed)).ok()?;
            let answer = self.answer(&registrar, model);
            answers.push(((shot.believed_rad - self.from_rad).abs(), answer));
            if evidence.accepted {
                let rate_rad_s = shot.turn_rad / EXPOSURE_S;
                let left = registrar.axis_turn(&points, &evidence.transform).unwrap();
                offsets.note(rate_rad_s, &believed, &evidence.transform, left);
            }
            let hand_from_camera = self.setup.camera_from_hand(shot.wrist_rad).inverse();
            let Some(hand_from_registered) = hand_from_registered else {
                // The first view makes the frame.
                hand_from_registered = Some(hand_from_camera * evidence.transform.inverse());
                continue;
            };
            if !evidence.accepted {
                seen.refused += 1.0;
                continue;
            }
            let off = hand_from_camera.inverse() * (hand_from_registered * evidence.transform);
            let middle = hand_from_camera.inverse() * Point3::new(0.0, 0.0, 0.19);
            seen.turned_deg += off.rotation.angle().to_degrees();
            seen.shifted_mm += 1e3 * (off * middle - middle).norm();
            poses += 1.0;
        }
        seen.offset = offsets.estimate();
        seen.turned_deg /= f64::max(poses, 1.0);
        seen.shifted_mm /= f64::max(poses, 1.0);
        seen.rms_mm = self.rms_mm(&registrar.cloud(), &hand_from_registered.unwrap());
        let (_, last) = answers.last().unwrap();
        let is_right = |answer: &Answer| answer.label == self.class.name();
        seen.right = f64::from(is_right(last));
        seen.harmful = f64::from(!is_right(last) && last.known);
        for (early, sure) in seen.early.iter_mut().zip(SURE) {
            let first = answers
                .iter()
                .find(|(_, answer)| answer.known && answer.probability >= sure);
            *early = first.map(|(turned_rad, answer)| Early {
                turned_rad: *turned_rad,
                changed: answer.label != last.label,
                wrong: !is_right(answer),
            });
        }
        Some(seen)
    }

    /// The answer to the views so far; known only where the scan is to be trusted, as in the graph.
    fn answer(&self, registrar: &Registrar, model: &mut Model) -> Answer {
        let cropper = Cropper::new(self.setup.crop.clone()).unwrap();
        let frame = Frame::Hand { opening_m: None };
        let object = cropper.crop(&registrar.cloud(), frame).unwrap();
        let mut answer = model.classify(&object.points, &object.up).unwrap();
        answer.known &= registrar.doubt().is_none();
        answer
    }

    /// From the registered points on the object to the true surface.
    fn rms_mm(&self, cloud: &[Point3<f32>], hand_from_registered: &Isometry3<f64>) -> f64 {
        let placed = cloud::transformed(hand_from_registered, cloud);
        let squares: Vec<f64> = placed
            .iter()
            .filter(|point| point.z > OBJECT_BOTTOM_Z_M)
            .map(|point| f64::from(self.surface.nearest(point).distance_sq))
            .collect();
        1e3 * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

/// Compares, and fails where the sweep is worse beyond chance.
fn compare(range_rad: f64) {
    let (scans, first_seed) = asked(8, FIRST_SEED);
    let mut model = model();
    let mut pairs = vec![];
    let mut offsets = vec![];
    let mut views = [0, 0];
    let mut ended = [0, 0];
    let (mut clocks, mut lab_offset_s) = (ClockDifference::default(), 0.0);
    let mut left_ms = vec![vec![]; LAB_SCANS as usize];
    for seed in (first_seed..).take(scans) {
        let mut bench = Bench::new(seed, range_rad);
        let place = ((seed - first_seed) % LAB_SCANS) as usize;
        if place == 0 {
            (clocks, lab_offset_s) = (ClockDifference::default(), bench.offset_s);
        }
        bench.offset_s = lab_offset_s + clocks.offset_s;
        left_ms[place].push(1e3 * bench.offset_s.abs());
        let (sweep, steps) = (bench.sweep(), bench.steps());
        views = [sweep.len(), steps.len()];
        let pair = [sweep, steps].map(|shots| bench.seen(&shots, &mut model, seed));
        for (ended, seen) in ended.iter_mut().zip(&pair) {
            *ended += usize::from(seen.is_none());
        }
        let [Some(sweep), Some(steps)] = pair else {
            println!("seed {seed}, {}: ended: {pair:?}", bench.class.name());
            continue;
        };
        let pair = [sweep, steps];
        if let Some(found) = sweep.offset {
            clocks.learn(found.offset_s, found.sigma_s);
        }
        if pair[0].right != pair[1].right {
            println!("seed {seed}, {}: {pair:?}", bench.class.name());
        }
        assert!(pair[1].offset.is_none(), "views at rest tell no offset");
        offsets.extend(pair[0].offset.map(|found| {
            // Images were taken earlier than their stamps say, where joints are ahead.
            (found.offset_s + bench.offset_s, found.sigma_s)
        }));
        pairs.push(pair);
    }
    println!(
        "{scans} scans from seed {first_seed} through {range_rad:.2} rad: {} views in a sweep, {} at rest; ended by \
         registration: {} sweeps, {} of steps",
        views[0], views[1], ended[0], ended[1]
    );
    for (place, left_ms) in left_ms
        .iter()
        .enumerate()
        .filter(|(_, left)| !left.is_empty())
    {
        let mean_ms = left_ms.iter().sum::<f64>() / left_ms.len() as f64;
        println!(
            "scan {} with these clocks: {mean_ms:.1} ms apart",
            place + 1
        );
    }
    let errors_ms: Vec<f64> = offsets
        .iter()
        .map(|(error_s, _)| 1e3 * error_s.abs())
        .collect();
    let within = offsets
        .iter()
        .filter(|(error_s, sigma_s)| error_s.abs() <= 2.0 * sigma_s);
    let within = within.count();
    if errors_ms.len() > 1 {
        println!(
            "time offset told by {} sweeps, off by {:.1} ms in the mean, within 2 sigma in {within}",
            errors_ms.len(),
            mean(&errors_ms).0
        );
    }
    for (index, sure) in SURE.iter().enumerate() {
        let early: Vec<Early> = pairs
            .iter()
            .filter_map(|pair| pair[0].early[index])
            .collect();
        let count = |of: fn(&Early) -> bool| early.iter().filter(|early| of(early)).count();
        let turned_rad =
            early.iter().map(|early| early.turned_rad).sum::<f64>() / early.len().max(1) as f64;
        println!(
            "sure at {sure}: {} of {scans} sweeps, after {turned_rad:.2} rad in the mean; {} of these answers changed by the end, {} wrong",
            early.len(),
            count(|early| early.changed),
            count(|early| early.wrong)
        );
    }
    type Figure = fn(&Seen) -> f64;
    // Its name, and whether more (1) or less (-1) is better.
    let figures: [(&str, Figure, f64); 6] = [
        ("right", |seen| seen.right, 1.0),
        ("known and wrong", |seen| seen.harmful, -1.0),
        ("cloud to surface, RMS, mm", |seen| seen.rms_mm, -1.0),
        ("pose, degrees", |seen| seen.turned_deg, -1.0),
        ("pose, mm", |seen| seen.shifted_mm, -1.0),
        ("refused views", |seen| seen.refused, -1.0),
    ];
    let mut worse = vec![];
    for (name, figure, good) in figures {
        let of =
            |which: usize| -> Vec<f64> { pairs.iter().map(|pair| figure(&pair[which])).collect() };
        let gain: Vec<f64> = pairs
            .iter()
            .map(|pair| good * (figure(&pair[0]) - figure(&pair[1])))
            .collect();
        let ((sweep, sweep_ci), (steps, steps_ci), (gain, gain_ci)) =
            (mean(&of(0)), mean(&of(1)), mean(&gain));
        println!(
            "{name:28} sweep {sweep:.3} ± {sweep_ci:.3}, steps {steps:.3} ± {steps_ci:.3}, better by {gain:.3} ± {gain_ci:.3}"
        );
        if gain + gain_ci < 0.0 {
            worse.push(name);
        }
    }
    assert!(worse.is_empty(), "the sweep is worse: {worse:?}");
}

#[test]
fn a_sweep_names_as_well_as_steps_through_1_2_rad() {
    compare(1.2);
}

#[test]
fn a_sweep_names_as_well_as_steps_through_half_a_turn() {
    compare(PI);
}
