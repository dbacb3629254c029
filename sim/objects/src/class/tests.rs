#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn names_round_trip() {
    for class in ObjectClass::ALL {
        assert_eq!(class.to_string().parse::<ObjectClass>().unwrap(), class);
    }
}

#[test]
fn unknown_name_lists_the_allowed_ones() {
    let text = "Medium-Can".parse::<ObjectClass>().unwrap_err().to_string();
    assert!(text.contains("'Medium-Can'"), "{text}");
    for class in ObjectClass::ALL {
        assert!(text.contains(class.name()), "{text}");
    }
}

/// Width and height in millimetres, as measured on scans of the real objects.
const SIZES_MM: [(ObjectClass, f32, f32); 8] = [
    (ObjectClass::MediumCan, 65.5, 127.4),
    (ObjectClass::FoodCan, 75.9, 118.5),
    (ObjectClass::SmallCup, 88.5, 102.9),
    (ObjectClass::MediumCup, 83.4, 126.7),
    (ObjectClass::LargeCup, 88.7, 171.1),
    (ObjectClass::TinyBall, 61.2, 63.8),
    (ObjectClass::SmallBall, 64.0, 64.7),
    (ObjectClass::MediumBall, 97.4, 90.0),
];

#[test]
fn extents_are_those_of_the_table() {
    for (class, width_mm, height_mm) in SIZES_MM {
        let mesh = class.mesh(&Variation::NONE);
        let (min, max) = mesh.bounds();
        let size_mm = (max - min) * 1000.0;
        assert!((size_mm.x - width_mm).abs() < 0.01, "{class}: {size_mm:?}");
        assert!((size_mm.y - width_mm).abs() < 0.01, "{class}: {size_mm:?}");
        assert!((size_mm.z - height_mm).abs() < 0.01, "{class}: {size_mm:?}");
        assert!(min.z.abs() < 1e-6, "{class} does not stand on its bottom");
    }
}

#[test]
fn meshes_are_closed_oriented_outward_and_of_moderate_size() {
    for class in ObjectClass::ALL {
        let mesh = class.mesh(&Variation::NONE);
        assert!(mesh.is_closed_manifold(), "{class}");
        assert!(mesh.volume_m3() > 0.0, "{class} is inside out");
        let count = mesh.triangles.len();
        assert!(
            (4_000..12_000).contains(&count),
            "{class}: {count} triangles"
        );
    }
}

#[test]
fn cups_are_open_at_the_top_and_the_others_are_not() {
    use ObjectClass::*;
    for class in ObjectClass::ALL {
        let mesh = class.mesh(&Variation::NONE);
        let height_m = mesh.bounds().1.z;
        let highest_at_axis_m = mesh
            .vertices
            .iter()
            .filter(|v| v.x.hypot(v.y) < 1e-6)
            .map(|v| v.z)
            .fold(f32::MIN, f32::max);
        let open = highest_at_axis_m < 0.15 * height_m;
        assert_eq!(
            open,
            [SmallCup, MediumCup, LargeCup].contains(&class),
            "{class}"
        );
    }
}
