#![allow(clippy::unwrap_used)]
use sim_objects::{ObjectClass, Variation};

use super::*;
use crate::grasp::GraspSettings;

/// A can of 6 x 12 cm with a vertex every 3 to 4 mm.
fn can() -> Mesh {
    let mut profile = vec![[0.0, 0.0], [0.015, 0.0]];
    profile.extend((0..=30).map(|k| [0.03, 0.004 * k as f32]));
    profile.extend([[0.015, 0.12], [0.0, 0.12]]);
    mesh::revolve(&profile, 48)
}

fn denter(mesh: Mesh) -> Denter {
    Denter::new(mesh, &Settings::default()).unwrap()
}

/// The first grasp of a seeded order that a gripper can take.
fn grasp(denter: &Denter, seed: u64) -> Grasp {
    println!("seed {seed}");
    let grasps = denter.grasps();
    let mut order = grasps.order(seed).into_iter();
    order.find_map(|handle| grasps.grasp(handle).ok()).unwrap()
}

#[test]
fn fingers_press_as_far_as_asked_and_the_ends_stay() {
    let denter = denter(can());
    for seed in 0..4 {
        let grasp = grasp(&denter, seed);
        let asked_m = [0.004, 0.006, 0.008, 0.010, 0.012, 0.014];
        let dents = denter.dent(&grasp, &asked_m).unwrap();
        for (dent, asked_m) in dents.iter().zip(asked_m) {
            assert_eq!((dent.asked_m, dent.applied_m), (asked_m, asked_m));
            for (&handle, direction) in grasp.handles.iter().zip(&grasp.directions) {
                let [from, to] =
                    [denter.source(), &dent.mesh].map(|mesh| mesh.vertices[handle as usize]);
                let moved_m = (to - from).cast::<f64>();
                assert!(
                    (moved_m - asked_m * direction.into_inner()).norm() < 1e-6,
                    "{moved_m}"
                );
            }
            for &held in denter.grasps().held() {
                let [from, to] =
                    [denter.source(), &dent.mesh].map(|mesh| mesh.vertices[held as usize]);
                assert_eq!(from, to);
            }
            assert_eq!(dent.mesh.triangles, denter.source().triangles);
            assert!(dent.mesh.volume_m3() < denter.source().volume_m3());
        }
        let grows = |value: fn(&Dent) -> f64| {
            dents
                .windows(2)
                .all(|pair| value(&pair[0]) < value(&pair[1]))
        };
        assert!(
            grows(|dent| dent.loss.distance_mm2),
            "deeper dents are farther from the source"
        );
        assert!(grows(|dent| dent.energy_m2), "and take more energy");
    }
}

#[test]
fn fingers_stop_before_they_meet() {
    let denter = denter(can());
    let grasp = grasp(&denter, 1);
    let limit_m = grasp.intensity_max_m;
    let dents = denter
        .dent(&grasp, &[0.5 * limit_m, limit_m, 2.0 * limit_m, 10.0])
        .unwrap();
    let applied_m: Vec<f64> = dents.iter().map(|dent| dent.applied_m).collect();
    assert!(
        applied_m.is_sorted() && applied_m.iter().all(|&applied_m| applied_m <= limit_m),
        "{applied_m:?}"
    );
    assert!(dents[2].mesh == dents[3].mesh);
}

/// A cup whose outer wall alone is pressed goes through its inner one, 1.6 mm behind.
fn cup_of_loose_walls() -> Denter {
    let settings = Settings {
        grasp: GraspSettings {
            wall_max_m: 1e-6,
            ..GraspSettings::default()
        },
        ..Settings::default()
    };
    Denter::new(ObjectClass::LargeCup.mesh(&Variation::NONE), &settings).unwrap()
}

#[test]
fn where_the_surface_would_pass_through_itself_the_intensity_is_lowered() {
    let denter = cup_of_loose_walls();
    let grasp = grasp(&denter, 2);
    let dents = denter.dent(&grasp, &[0.001, 0.004, 0.008]).unwrap();
    let applied_m: Vec<f64> = dents.iter().map(|dent| dent.applied_m).collect();
    println!("applied {applied_m:?}");
    assert_eq!(applied_m[0], 0.001);
    assert!((0.001..0.0025).contains(&applied_m[1]) && applied_m[2] == applied_m[1]);
    assert_eq!((dents[1].mesh == dents[2].mesh, dents[2].tries), (true, 0));
    for dent in &dents {
        assert_eq!(
            SelfIntersections::of(&dent.mesh).source_pairs(),
            [[0; 2]; 0]
        );
    }
    // Asked the other way round, what was too deep is remembered.
    let dents = denter.dent(&grasp, &[0.008, 0.004]).unwrap();
    assert_eq!(dents[0].applied_m, dents[1].applied_m);
    assert!(dents[0].tries <= 7, "{} deformations", dents[0].tries);
}

#[test]
fn both_walls_of_a_cup_give_way_together() {
    for class in [
        ObjectClass::SmallCup,
        ObjectClass::MediumCup,
        ObjectClass::LargeCup,
    ] {
        let denter = denter(class.mesh(&Variation::NONE).subdivided());
        let mut shares = Vec::new();
        for seed in 0..3 {
            let dents = denter.dent(&grasp(&denter, seed), &[0.004, 0.008]).unwrap();
            shares.extend(dents.iter().map(|dent| dent.applied_m / dent.asked_m));
        }
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        assert!(mean > 0.85, "{class}: {shares:?}");
    }
}

#[test]
fn the_same_grasp_gives_the_same_bytes() {
    let denter = denter(ObjectClass::SmallBall.mesh(&Variation::NONE));
    let grasp = grasp(&denter, 4);
    let dents = || denter.dent(&grasp, &[0.004, 0.010]).unwrap();
    assert!(dents() == dents());
}

#[test]
fn what_cannot_be_meant_is_refused_by_value() {
    let denter = denter(can());
    let grasp = grasp(&denter, 5);
    for asked_m in [0.0, -0.001, f64::NAN, f64::INFINITY] {
        let text = denter.dent(&grasp, &[asked_m]).unwrap_err().to_string();
        assert!(text.contains(&asked_m.to_string()), "{text}");
    }
    let settings: Result<Settings, _> =
        serde_json::from_str(r#"{"grasp": {"finger_width_mm": 8}}"#);
    assert!(
        settings
            .unwrap_err()
            .to_string()
            .contains("finger_width_mm")
    );
    assert_eq!(
        serde_json::from_str::<Settings>("{}").unwrap(),
        Settings::default()
    );
}

#[test]
fn a_dent_of_the_printed_energy_is_another_one() {
    let settings = Settings {
        energy: crate::Energy::Laplacian,
        ..Settings::default()
    };
    let printed = Denter::new(can(), &settings).unwrap();
    let rigid = denter(can());
    let grasp = grasp(&rigid, 2);
    let dent = |denter: &Denter| denter.dent(&grasp, &[0.008]).unwrap().remove(0);
    let (printed, rigid) = (dent(&printed), dent(&rigid));
    let apart = printed.mesh.vertices.iter().zip(&rigid.mesh.vertices);
    let farthest_m = apart.map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
    println!("{farthest_m} m apart");
    assert!((0.0005..0.008).contains(&farthest_m));
}
