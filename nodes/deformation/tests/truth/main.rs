//! Simulated scans whose dents are known; examples/truth.rs makes the same table of many more.
#![allow(clippy::unwrap_used)]

#[path = "../common/mod.rs"]
mod common;

use common::score::{Row, Table, csv};
use common::{Case, Pads, references};
use deformation::{Doubt, Observation, Parameters, measure};
use nalgebra::Vector3;

/// As many scans as make each object and depth appear once; more by the environment.
fn scans() -> usize {
    let wanted = std::env::var("DEFORMATION_SCANS").ok();
    wanted.map_or(32, |count| count.parse().unwrap())
}

#[test]
fn dents_are_found_where_they_are_and_nowhere_else() {
    let first_seed = 700;
    println!("seeds from {first_seed}");
    let references = references().unwrap();
    let rows: Vec<Row> = (0..scans())
        .filter_map(|number| Case::numbered(number, first_seed, Pads::Both).unwrap())
        .map(|case| Row::of(&case, &references[case.class.as_str()]))
        .collect();
    let table = Table::of(&rows);
    println!("{table}{}", csv(&rows));
    assert!(table.auroc >= 0.97, "{table}");
    assert!(table.false_dents * 8 <= table.undented, "{table}");
    for [asked_m, bias_m, _, mean_m, _] in &table.depths[..2] {
        assert!(
            bias_m.abs() < 0.0012 && *mean_m < 0.0018,
            "at {asked_m} m: {table}"
        );
    }
    assert!(table.centre_m[0] < 0.005, "{table}");
    assert!(table.direction_rad[0] < 10f64.to_radians(), "{table}");
    let unseen = &table.unseen;
    let wrong = unseen.errors_m().iter().filter(|&&m| m > 0.004).count();
    assert!(4 * wrong <= unseen.claims.len(), "{table}");
    assert!(unseen.shape_m[0] < unseen.rest_m[0], "{table}");
    assert!(unseen.shape_m[1] < unseen.rest_m[1], "{table}");
}

#[test]
fn where_only_one_pad_pressed_no_dent_is_claimed_on_the_other_side() {
    let first_seed = 750;
    println!("seeds from {first_seed}");
    let references = references().unwrap();
    let rows: Vec<Row> = (8..32)
        .filter_map(|number| Case::numbered(number, first_seed, Pads::One).unwrap())
        .map(|case| Row::of(&case, &references[case.class.as_str()]))
        .collect();
    assert!(rows.iter().any(|row| row.unseen.shape_m.is_some()));
    for claim in rows.iter().flat_map(|row| &row.unseen.claims) {
        assert!(claim.truth_m > 0.002, "{claim:?}");
    }
}

#[test]
fn the_own_reference_fits_and_one_of_another_kind_of_object_does_not() {
    let references = references().unwrap();
    for number in [0, 4, 7] {
        let case = Case::numbered(number, 700, Pads::Both).unwrap().unwrap();
        for (name, reference) in &references {
            let found = measure(reference, &case.observation(), &Parameters::default());
            let fits = found.is_ok_and(|found| found.fits());
            assert!(fits || *name != case.class, "{} is refused", case.class);
            let is_far = matches!(
                (case.class.as_str(), *name),
                ("medium-can", "medium-ball")
                    | ("large-cup", "tiny-ball")
                    | ("medium-ball", "tiny-ball" | "medium-can")
            );
            assert!(!(fits && is_far), "{} is taken for {name}", case.class);
        }
    }
}

#[test]
fn nothing_is_said_of_what_cannot_be_judged() {
    let references = references().unwrap();
    let reference = &references["medium-can"];
    let case = Case::numbered(0, 700, Pads::Both).unwrap().unwrap();
    let seen = |points| Observation {
        points,
        ..case.observation()
    };
    let parameters = Parameters::default();
    let empty = measure(reference, &seen(&[]), &parameters);
    assert!(matches!(empty, Err(Doubt::DoesNotFit { .. })));
    let corner: Vec<_> = case.points.iter().filter(|p| p.x > 0.03).copied().collect();
    let little = seen(&corner[..60.min(corner.len())]);
    if let Ok(little) = measure(reference, &little, &parameters) {
        assert!(little.doubt.is_some() && little.dents.is_empty());
        let words = little.words(&Vector3::z(), None);
        assert!(words.starts_with("nothing said of dents"), "{words}");
    }
}

#[test]
fn an_object_upside_down_is_recognised_as_such() {
    let references = references().unwrap();
    let mut case = Case::numbered(2, 700, Pads::Both).unwrap().unwrap();
    let parameters = Parameters::default();
    let upright = measure(
        &references[case.class.as_str()],
        &case.observation(),
        &parameters,
    );
    let over = nalgebra::Isometry3::rotation(Vector3::x() * std::f64::consts::PI);
    let lift = nalgebra::Translation3::new(0.0, 0.0, 0.5);
    let turn = lift * over;
    case.points
        .iter_mut()
        .for_each(|p| *p = (turn * p.cast::<f64>()).cast());
    case.viewpoints.iter_mut().for_each(|p| *p = turn * *p);
    let hanging = measure(
        &references[case.class.as_str()],
        &case.observation(),
        &parameters,
    );
    let up =
        |found: &deformation::Measured| found.placement.object_from_cloud.inverse() * Vector3::z();
    let (upright, hanging) = (upright.unwrap(), hanging.unwrap());
    assert!(up(&upright).z > 0.99 && up(&hanging).z < -0.99);
    assert!((upright.undented_rms_m - hanging.undented_rms_m).abs() < 2e-4);
}
