#![allow(clippy::unwrap_used)]
use nalgebra::Translation3;

use super::*;

fn held(text: &str) -> Held {
    let Ok(held) = text.parse();
    held
}

#[test]
fn a_file_of_millimetres_is_held_upright_like_its_object() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("can.ply");
    let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
    let elsewhere = can.transformed(&Translation3::new(0.3, -0.2, 0.1).into());
    file::write_ply(&path, &elsewhere).unwrap();
    let read = held(path.to_str().unwrap()).mesh(0.0, 1).unwrap().unwrap();
    assert_eq!(read.triangles, can.triangles);
    for (read, own) in read.vertices.iter().zip(&can.vertices) {
        assert!((read - own).norm() < 1e-6, "{read} is not {own}");
    }
    let dented = held(path.to_str().unwrap())
        .mesh(0.008, 1)
        .unwrap()
        .unwrap();
    assert!(dented.volume_m3() < read.volume_m3());
}

#[test]
fn an_object_upside_down_stands_on_its_other_end_and_turns_about_its_axis() {
    let cup = ObjectClass::LargeCup.mesh(&Variation::NONE);
    let held = Grip {
        upside_down: true,
        turn_rad: 0.5,
    }
    .place(&cup);
    let height_m = cup.bounds().1.z;
    for (held, own) in held.vertices.iter().zip(&cup.vertices) {
        assert!((held.z - (height_m - own.z)).abs() < 1e-6);
        assert!((held.x.hypot(held.y) - own.x.hypot(own.y)).abs() < 1e-6);
    }
    assert!((held.volume_m3() - cup.volume_m3()).abs() < 1e-9);
    let turned = Grip {
        turn_rad: 0.5,
        ..Grip::default()
    };
    let angle = |v: &nalgebra::Point3<f32>| v.y.atan2(v.x);
    let (first, own) = (turned.place(&cup).vertices[64], cup.vertices[64]);
    assert!((angle(&first) - angle(&own) - 0.5).abs() < 1e-4);
}

#[test]
fn names_that_mean_nothing_are_refused_with_what_is_meant() {
    assert_eq!(held("").mesh(0.0, 1).unwrap(), None);
    let text = held("teapot").mesh(0.0, 1).unwrap_err().to_string();
    assert!(
        ["teapot", "medium-can", ".ply"]
            .iter()
            .all(|word| text.contains(word)),
        "{text}"
    );
    let text = held("/nowhere/can.ply")
        .mesh(0.0, 1)
        .unwrap_err()
        .to_string();
    assert!(text.contains("/nowhere/can.ply"), "{text}");
    let text = held("small-ball").mesh(0.1, 1).unwrap_err().to_string();
    assert!(text.contains("squeeze is 0.1 m"), "{text}");
}
