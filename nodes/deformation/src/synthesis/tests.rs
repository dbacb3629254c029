#![allow(clippy::unwrap_used)]
use nalgebra::{Point3, Vector3};
use sim_deform::{Denter, Settings};
use sim_objects::{ObjectClass, Variation};

use super::*;
use crate::shell::Pad;
use crate::{Observation, measure};

/// An object that the generator has squeezed, and where.
struct Squeezed {
    reference: Reference,
    fine: Vec<Point3<f64>>,
    dented: Vec<Point3<f64>>,
    pads: [Pad; 2],
}

fn squeezed(class: ObjectClass, depth_m: f64, seed: u64) -> Squeezed {
    let mesh = class.mesh(&Variation::NONE);
    let reference = Reference::new(class.name(), &mesh).unwrap();
    let fine = mesh.vertices.iter().map(|v| v.cast()).collect();
    let denter = Denter::new(mesh, &Settings::default()).unwrap();
    let grasps = denter.grasps();
    let grasp = grasps
        .order(seed)
        .into_iter()
        .find_map(|handle| grasps.grasp(handle).ok())
        .unwrap();
    let dent = denter.dent(&grasp, &[depth_m]).unwrap().remove(0);
    let fine: Vec<Point3<f64>> = fine;
    let pads = [0, 1].map(|k| Pad {
        centre: fine[grasp.handles[k] as usize],
        normal: -grasp.directions[k].into_inner(),
        depth_m: dent.applied_m,
    });
    Squeezed {
        reference,
        dented: dent.mesh.vertices.iter().map(|v| v.cast()).collect(),
        fine,
        pads,
    }
}

impl Squeezed {
    /// The dented wall as far as it is seen up to this angle about the axis from the first pad.
    fn seen_up_to(&self, angle_rad: f64) -> Vec<Point3<f32>> {
        let first = Vector3::new(self.pads[0].centre.x, self.pads[0].centre.y, 0.0);
        let pairs = self.fine.iter().zip(&self.dented);
        let is_seen = |(from, _): &(&Point3<f64>, &Point3<f64>)| {
            let way = Vector3::new(from.x, from.y, 0.0);
            way.norm() > 0.02 && way.angle(&first) < angle_rad
        };
        let seen: Vec<Point3<f64>> = pairs.filter(is_seen).map(|(_, to)| *to).collect();
        // As many points as a camera would give: each again a little aside.
        let aside = |k: usize, place: &Point3<f64>| {
            let nearest = seen[k + 1..]
                .iter()
                .find(|other| (*other - place).norm() < 0.005);
            nearest.map_or(*place, |other| nalgebra::center(place, other))
        };
        let between = seen.iter().enumerate().map(|(k, place)| aside(k, place));
        seen.iter()
            .copied()
            .chain(between)
            .map(|place| place.cast())
            .collect()
    }
}

fn answer(squeezed: &Squeezed, angle_rad: f64, synthesis: bool) -> crate::Measured {
    let points = squeezed.seen_up_to(angle_rad);
    let seen = Observation {
        points: &points,
        up: Vector3::z(),
        viewpoints: &[],
        in_hand_frame: true,
    };
    let parameters = Parameters {
        synthesis,
        ..Parameters::default()
    };
    measure(&squeezed.reference, &seen, &parameters).unwrap()
}

#[test]
fn the_coarse_shell_gives_way_as_the_generators_fine_mesh_does() {
    for (class, seed) in [(ObjectClass::MediumCan, 3), (ObjectClass::MediumCup, 4)] {
        println!("{class}, seed {seed}");
        let truth = squeezed(class, 0.008, seed);
        let shell = truth.reference.shell.as_ref().unwrap();
        let depths_m = truth.pads.map(|pad| pad.depth_m);
        let moved_m = shell.press(&truth.pads).unwrap().moved(depths_m).unwrap();
        let outer = &truth.reference.outer;
        let (mut sum_m2, mut count, mut deepest_m) = (0.0, 0.0, 0.0f64);
        for (from, to) in truth.fine.iter().zip(&truth.dented) {
            let sample = &outer.samples[outer.nearest(&from.cast())];
            if (sample.point.cast::<f64>() - from).norm() > 0.001 {
                continue; // inside a cup
            }
            let normal: Vector3<f64> = sample.normal.cast();
            let ours_m = shell.spot(from).of(&moved_m).dot(&normal);
            let true_m = (to - from).dot(&normal);
            sum_m2 += (ours_m - true_m).powi(2);
            count += 1.0;
            deepest_m = deepest_m.max(-ours_m);
        }
        let rms_m = (sum_m2 / count).sqrt();
        assert!(rms_m < 0.0006, "{class}: {rms_m} m");
        assert!(
            (deepest_m - depths_m[0]).abs() < 0.001,
            "{class}: {deepest_m} m"
        );
    }
}

#[test]
fn a_dent_whose_rim_is_seen_is_known_and_one_of_which_nothing_is_seen_is_not() {
    let truth = squeezed(ObjectClass::MediumCan, 0.010, 3);
    let rim = answer(&truth, 2.75, true);
    let [dent] = rim.unseen_dents() else {
        panic!("{:?}", rim.unsaid());
    };
    println!("{dent:?}");
    assert!((dent.depth_m - truth.pads[1].depth_m).abs() < 0.0025);
    assert!((dent.centre_in_object - truth.pads[1].centre).norm() < 0.01);
    assert!(rim.unsaid().is_none());
    let words = rim.words(&Vector3::z(), None);
    assert!(words.contains("; unseen, by its rim: "), "{words}");
    let nothing = answer(&truth, 1.3, true);
    assert!(
        matches!(nothing.unsaid(), Some(Unsaid::Open { .. })),
        "{:?}",
        nothing.unsaid()
    );
    assert!(nothing.unseen_dents().is_empty());
    let words = nothing.words(&Vector3::z(), None);
    assert!(words.ends_with("; unseen side: not known"), "{words}");
}

#[test]
fn switched_off_or_without_a_dent_the_answer_is_that_of_the_first_stage() {
    let truth = squeezed(ObjectClass::MediumCan, 0.010, 3);
    let (on, off) = (answer(&truth, 2.6, true), answer(&truth, 2.6, false));
    assert_eq!(off.unsaid(), Some(&Unsaid::Off));
    assert_eq!((&on.dents, &on.placement), (&off.dents, &off.placement));
    assert_eq!(on.deviations_m.len(), off.deviations_m.len());
    assert!(!off.words(&Vector3::z(), None).contains("unseen"));
    let undented = Squeezed {
        dented: truth.fine.clone(),
        ..truth
    };
    let answer = answer(&undented, 2.6, true);
    assert_eq!(
        (answer.dents.len(), answer.unsaid()),
        (0, Some(&Unsaid::NoDent))
    );
}

#[test]
fn a_mesh_that_cannot_be_deformed_is_named() {
    let mesh = ObjectClass::TinyBall.mesh(&Variation::NONE);
    let reference = Reference::new("ball", &mesh).unwrap();
    let nothing = mesh::Mesh {
        triangles: Vec::new(),
        ..mesh
    };
    let refused = Shell::new(&nothing, &reference.outer, None).err().unwrap();
    let text = Unsaid::from(refused).to_string();
    assert!(
        text.contains("cannot be deformed") && text.contains("at least one triangle"),
        "{text}"
    );
}
