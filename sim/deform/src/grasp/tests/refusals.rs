//! What cannot be grasped, and why.

use super::*;

#[test]
fn where_no_finger_can_press_the_reason_is_named() {
    let can = can();
    let all = grasps(&can);
    let held = all.held()[0];
    assert_eq!(
        all.grasp(held),
        Err(GraspRefused::OutsideRegion { handle: held })
    );
    let handle = middle(&can, 0.06);

    let narrow = GraspSettings {
        opening_max_m: 0.05,
        ..GraspSettings::default()
    };
    let refused = Grasps::new(&can, &narrow)
        .unwrap()
        .grasp(handle)
        .unwrap_err();
    assert!(matches!(refused, GraspRefused::TooWide { .. }));
    assert!(refused.to_string().contains("0.0600") && refused.to_string().contains("0.05 m"));

    let straw = barrel(|_| 0.001, 0.12, 60, 16);
    let refused = grasps(&straw).grasp(middle(&straw, 0.06)).unwrap_err();
    assert!(matches!(refused, GraspRefused::TooThin { .. }), "{refused}");

    // A lying plate: its long side is across, and its face looks along the given one.
    let plate = barrel(|_| 0.04, 0.02, 10, 64);
    let upright = GraspSettings {
        long_axis: Some(Vector3::z_axis()),
        graspable_ratio: 0.999,
        ..GraspSettings::default()
    };
    let dome = barrel(
        |share| 0.04 * (1.0 - share * share).sqrt().max(0.02),
        0.004,
        20,
        64,
    );
    let upper = middle(&dome, 0.0034);
    let refused = Grasps::new(&dome, &upright)
        .unwrap()
        .grasp(upper)
        .unwrap_err();
    assert!(matches!(refused, GraspRefused::EndCap { .. }), "{refused}");
    assert!(
        Grasps::new(&plate, &upright)
            .unwrap()
            .grasp(middle(&plate, 0.01))
            .is_ok()
    );

    let cup = ObjectClass::LargeCup.mesh(&Variation::NONE);
    let in_cup = grasps(&cup);
    let is_inside = |v: &&u32| {
        let (at, normal) = (in_cup.position(**v), in_cup.surface.normals[**v as usize]);
        (0.06..0.12).contains(&at.z) && normal.xy().dot(&at.coords.xy()) < 0.0
    };
    let inside = *in_cup.region().iter().find(is_inside).unwrap();
    let refused = in_cup.grasp(inside).unwrap_err();
    assert!(
        matches!(refused, GraspRefused::NotFacing { .. }),
        "{refused}"
    );
}

#[test]
fn a_vertex_alone_in_its_slice_has_no_opposite() {
    let mut mesh = can();
    let handle = middle(&mesh, 0.06);
    mesh.vertices[handle as usize].z += 0.001;
    let thin = GraspSettings {
        slice_m: 1e-4,
        ..GraspSettings::default()
    };
    let refused = Grasps::new(&mesh, &thin)
        .unwrap()
        .grasp(handle)
        .unwrap_err();
    assert_eq!(refused, GraspRefused::NoOpposite { handle });
}

#[test]
fn meshes_and_settings_that_cannot_be_meant_are_refused() {
    let refused = |mesh: &Mesh| Grasps::new(mesh, &GraspSettings::default()).err().unwrap();
    assert!(matches!(
        refused(&Mesh::default()),
        GraspError::Empty { .. }
    ));
    let mut mesh = can();
    mesh.triangles.iter_mut().for_each(|t| t.reverse());
    assert_eq!(refused(&mesh), GraspError::InsideOut);
    let mut mesh = can();
    mesh.triangles[3][1] = 100_000;
    assert!(matches!(
        refused(&mesh),
        GraspError::Index { triangle: 3, .. }
    ));
    let mut mesh = can();
    mesh.vertices[5].y = f32::NAN;
    assert_eq!(refused(&mesh), GraspError::NotFinite { vertex: 5 });
    let cube = Mesh::cuboid(
        Point3::new(-0.01, -0.01, -0.01),
        Point3::new(0.01, 0.01, 0.01),
    );
    assert!(matches!(refused(&cube), GraspError::NoRegion { .. }));

    for value in [0.0, -1.0, f64::NAN] {
        let settings = GraspSettings {
            finger_width_m: value,
            ..GraspSettings::default()
        };
        let text = settings.validate().unwrap_err().to_string();
        assert!(
            text.contains("finger_width_m") && text.contains(&value.to_string()),
            "{text}"
        );
    }
}
