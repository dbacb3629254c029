use mesh::Mesh;
use nalgebra::Point3;

use super::{pinch, rims, tube};
use crate::MeshFault;
use crate::{Arap, ArapError, ArapSettings};

fn refusal(mesh: &Mesh, held: &[u32]) -> ArapError {
    Arap::new(mesh, held, ArapSettings::default()).unwrap_err()
}

#[test]
fn unfit_meshes_are_refused_with_what_is_wrong() {
    let mesh = tube(31, 6, 4);
    assert!(matches!(
        refusal(&Mesh::default(), &[]),
        ArapError::Mesh(MeshFault::Empty { .. })
    ));
    let mut broken = mesh.clone();
    broken.triangles.clear();
    assert!(matches!(
        refusal(&broken, &[]),
        ArapError::Mesh(MeshFault::Empty { .. })
    ));
    let mut broken = mesh.clone();
    broken.vertices[7].y = f32::NAN;
    assert!(matches!(
        refusal(&broken, &[]),
        ArapError::Mesh(MeshFault::NotFinite { vertex: 7, .. })
    ));
    let mut broken = mesh.clone();
    broken.triangles[3][1] = 24;
    let expected = MeshFault::NoSuchVertex {
        triangle: 3,
        vertex: 24,
        vertices: 24,
    };
    assert_eq!(refusal(&broken, &[]), ArapError::Mesh(expected));
    let mut broken = mesh.clone();
    broken.triangles[2] = [5, 9, 9];
    let expected = MeshFault::RepeatedCorner {
        triangle: 2,
        vertex: 9,
    };
    assert_eq!(refusal(&broken, &[]), ArapError::Mesh(expected));
    let mut broken = mesh.clone();
    broken.vertices.extend([Point3::origin(); 3]);
    let expected = MeshFault::Isolated {
        first: 24,
        count: 3,
    };
    assert_eq!(refusal(&broken, &[]), ArapError::Mesh(expected));
}

#[test]
fn impossible_constraints_are_refused_by_index() {
    let mesh = tube(32, 6, 4);
    let text = |held: &[u32]| refusal(&mesh, held).to_string();
    assert_eq!(
        text(&[1, 24]),
        "vertex 24 is to be held, but there are 24 vertices; indices start at 0"
    );
    assert_eq!(
        text(&[3, 1, 3]),
        "vertex 3 is held twice; name each vertex once"
    );
    let arap = Arap::new(&mesh, &rims(6, 4), ArapSettings::default()).unwrap();
    let text = |handles: &[u32]| arap.grip(handles).unwrap_err().to_string();
    assert!(text(&[8, 99]).contains("vertex 99"));
    assert!(text(&[8, 8]).contains("vertex 8 is a handle twice"));
    assert!(text(&[8, 2]).contains("vertex 2 is a handle, but it is held"));
    let (handles, mut targets_m) = pinch(&mesh, 6, 0.01);
    let mut grip = arap.grip(&handles).unwrap();
    let few = grip.deform(&targets_m[..1]).unwrap_err();
    assert_eq!(
        few.to_string(),
        "1 targets for 2 handles; each handle needs one"
    );
    for bad in [f64::NAN, f64::INFINITY, 1e200] {
        targets_m[1].z = bad;
        assert!(matches!(
            grip.deform(&targets_m),
            Err(ArapError::Target { index: 1, .. })
        ));
    }
}

#[test]
fn a_part_that_nothing_constrains_is_named() {
    let mut mesh = tube(33, 6, 4);
    mesh.append(&tube(34, 6, 5));
    let arap = Arap::new(&mesh, &rims(6, 4), ArapSettings::default()).unwrap();
    let expected = ArapError::Unconstrained {
        vertex: 24,
        size: 30,
    };
    assert_eq!(arap.grip(&[8]).unwrap_err(), expected);
    let target = mesh.vertices[40].cast() + nalgebra::Vector3::new(0.0, 0.01, 0.0);
    let deformed = arap.grip(&[40]).unwrap().deform(&[target]).unwrap();
    let moved = deformed
        .vertices_m
        .iter()
        .zip(&mesh.vertices)
        .map(|(now, then)| (now - then.cast::<f64>()).norm());
    let moved: Vec<f64> = moved.collect();
    assert!(
        moved[..24].iter().all(|&way| way < 1e-12)
            && moved[24..].iter().all(|&way| (way - 0.01).abs() < 1e-12)
    );
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let mesh = tube(35, 6, 4);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let settings = ArapSettings {
            smoothness: bad,
            ..Default::default()
        };
        let text = Arap::new(&mesh, &[], settings).unwrap_err().to_string();
        assert!(
            text.contains("smoothness") && text.contains(&bad.to_string()),
            "{text}"
        );
        let settings = ArapSettings {
            energy_change_min: bad,
            ..Default::default()
        };
        assert!(
            Arap::new(&mesh, &[], settings)
                .unwrap_err()
                .to_string()
                .contains("energy_change_min")
        );
    }
}

#[test]
fn triangles_without_area_do_no_harm() {
    let (around, rings) = (12, 10);
    let mut mesh = tube(36, around, rings);
    // Vertices that coincide, and one in the middle of the opposite edge.
    mesh.vertices[40] = mesh.vertices[41];
    mesh.vertices[64] = nalgebra::center(&mesh.vertices[63], &mesh.vertices[65]);
    let arap = Arap::new(&mesh, &rims(around, rings), ArapSettings::default()).unwrap();
    let (handles, targets_m) = pinch(&mesh, around, 0.01);
    let deformed = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
    assert!(deformed.energy_m2.is_finite());
    assert!(
        deformed
            .vertices_m
            .iter()
            .all(|place| place.coords.norm() < 0.2)
    );
    assert!(
        deformed
            .energies_m2
            .windows(2)
            .all(|pair| pair[1] <= pair[0])
    );
}

#[test]
fn a_mesh_without_area_is_refused() {
    let mut mesh = tube(37, 6, 4);
    mesh.vertices.fill(Point3::new(0.1, 0.2, 0.3));
    let refused = Arap::new(&mesh, &rims(6, 4), ArapSettings::default());
    assert!(matches!(refused, Err(ArapError::Singular { .. })));
}
