//! Recorded objects, where they are to be had.

use std::path::{Path, PathBuf};

use deformation::{Measured, Observation, Parameters, Reference, measure};
use icp_registration::{InitialGuess, Registrar};
use nalgebra::{Point3, Vector3};
use roi_crop::{Cropper, Frame};

use super::common::references;

fn folder() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = std::env::var_os("DEFORMABLE_COBOT_REAL").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        eprintln!("skipped: there is no {}", folder.display());
        return None;
    }
    Some(folder)
}

/// A can, recorded from three sides, that was pressed flat on one of them.
fn can(folder: &Path) -> (Vec<Point3<f32>>, Vec<Point3<f64>>) {
    let mut registrar = Registrar::new(icp_registration::Parameters {
        initial_guess: InitialGuess::Identity,
        ..icp_registration::Parameters::default()
    })
    .unwrap();
    let mut viewpoints = Vec::new();
    for number in 1..=3 {
        let path = folder.join(format!("captures/can_a/out_{number}.ply"));
        let view = cloud::read(path).unwrap().points;
        let evidence = registrar.add_view(&view, None).unwrap();
        viewpoints.push(Point3::from(evidence.transform.translation.vector));
    }
    let cropper = Cropper::new(roi_crop::Parameters::default()).unwrap();
    let object = cropper.crop(&registrar.cloud(), Frame::Camera).unwrap();
    (object.points, viewpoints)
}

fn report(name: &str, found: &Measured, up: &Vector3<f64>, viewpoints: &[Point3<f64>]) {
    println!(
        "{name}: {}; {:?}, {:.2} mm where undented, {:.0} % seen, scales {:.3} {:.3}",
        found.words(up, viewpoints.last()),
        found.doubt,
        1e3 * found.undented_rms_m,
        100.0 * found.seen_share,
        found.placement.width_scale,
        found.placement.height_scale
    );
    for dent in &found.dents {
        println!(
            "  {:.1} mm deep, {:.0} x {:.0} mm, at {:.0} mm, towards {:.2?}, {:.1} sigma",
            1e3 * dent.depth_m,
            1e3 * dent.width_m,
            1e3 * dent.height_m,
            1e3 * dent.centre_in_object.z,
            dent.direction.as_slice(),
            dent.significance
        );
    }
}

#[test]
fn the_can_that_was_pressed_flat_is_dented_and_a_can() {
    let Some(folder) = folder() else { return };
    let (points, viewpoints) = can(&folder);
    let up = Vector3::y();
    let seen = Observation {
        points: &points,
        up,
        viewpoints: &viewpoints,
        in_hand_frame: false,
    };
    let references = references().unwrap();
    for (name, reference) in &references {
        match measure(reference, &seen, &Parameters::default()) {
            Ok(found) => report(name, &found, &up, &viewpoints),
            Err(doubt) => println!("{name}: {doubt}"),
        }
    }
    let found = measure(&references["medium-can"], &seen, &Parameters::default()).unwrap();
    assert!(found.fits());
    let dent = found.dents.first().unwrap();
    assert!(dent.depth_m > 0.004, "{dent:?}");
}

#[test]
fn objects_seen_elsewhere_are_measured_or_doubted() {
    let Some(folder) = folder() else { return };
    let references = references().unwrap();
    for (scene, label) in [
        ("can_red_bag", "medium-can"),
        ("cup_red_30", "large-cup"),
        ("cup_pink_30", "medium-cup"),
        ("tin_nuts", "food-can"),
    ] {
        let points = cloud::read(folder.join(format!("elsewhere/{scene}/view.ply")))
            .unwrap()
            .points;
        let seen = Observation {
            points: &points,
            up: Vector3::z(),
            viewpoints: &[],
            in_hand_frame: false,
        };
        let reference: &Reference = &references[label];
        match measure(reference, &seen, &Parameters::default()) {
            Ok(found) => report(scene, &found, &Vector3::z(), &[]),
            Err(doubt) => println!("{scene}: {doubt}"),
        }
    }
}
