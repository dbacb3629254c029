#![allow(clippy::unwrap_used)]
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Vector3};
use sim_objects::{ObjectClass, Variation};

use super::*;
use crate::grasp::GraspSettings;

const CUPS: [ObjectClass; 3] = [
    ObjectClass::SmallCup,
    ObjectClass::MediumCup,
    ObjectClass::LargeCup,
];

fn lining(mesh: &Mesh) -> Lining {
    let settings = GraspSettings::default();
    let grasps = Grasps::new(mesh, &settings).unwrap();
    Lining::new(mesh, &grasps, settings.wall_max_m)
}

fn places(mesh: &Mesh) -> Vec<Point3<f64>> {
    mesh.vertices.iter().map(|v| v.cast()).collect()
}

#[test]
fn cups_have_an_inner_wall_and_solid_objects_have_none() {
    for class in ObjectClass::ALL {
        let mesh = class.mesh(&Variation::NONE);
        let count = lining(&mesh).rides.len();
        println!("{class}: {count} of {}", mesh.vertices.len());
        assert_eq!(
            count > mesh.vertices.len() / 5,
            CUPS.contains(&class),
            "{class}: {count}"
        );
        assert!(count == 0 || CUPS.contains(&class), "{class}: {count}");
    }
}

#[test]
fn a_wall_that_is_moved_rigidly_takes_its_lining_along() {
    let motion = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.5, 1.0, -0.7));
    for class in CUPS {
        let mesh = class.mesh(&Variation::NONE);
        let lining = lining(&mesh);
        for motion in [Isometry3::identity(), motion] {
            let expected: Vec<Point3<f64>> = places(&mesh).iter().map(|v| motion * v).collect();
            let mut moved = expected.clone();
            lining.lay(&mut moved);
            for ride in &lining.rides {
                let vertex = ride.vertex as usize;
                let error_m = (moved[vertex] - expected[vertex]).norm();
                assert!(
                    error_m < 1e-9,
                    "{class}: vertex {vertex} is {error_m} m off"
                );
            }
        }
    }
}
