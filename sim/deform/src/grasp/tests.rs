#![allow(clippy::unwrap_used)]
use std::collections::HashSet;

use mesh::Mesh;
use nalgebra::{Isometry3, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};

use super::*;

mod refusals;

/// Rings about z, a vertex on the axis at either end.
fn barrel(radius_m: impl Fn(f32) -> f32, height_m: f32, rings: usize, segments: usize) -> Mesh {
    let mut profile = vec![[0.0, 0.0]];
    profile.extend((0..=rings).map(|k| {
        let share = k as f32 / rings as f32;
        [radius_m(share), share * height_m]
    }));
    profile.push([0.0, height_m]);
    mesh::revolve(&profile, segments)
}

fn can() -> Mesh {
    barrel(|_| 0.03, 0.12, 60, 64)
}

fn grasps(mesh: &Mesh) -> Grasps {
    Grasps::new(mesh, &GraspSettings::default()).unwrap()
}

/// A vertex half-way up, on the side.
fn middle(mesh: &Mesh, height_m: f32) -> u32 {
    let rank = |v: &Point3<f32>| 1e3 * (v.z - height_m).abs() - v.coords.xy().norm();
    let order =
        |a: &usize, b: &usize| rank(&mesh.vertices[*a]).total_cmp(&rank(&mesh.vertices[*b]));
    (0..mesh.vertices.len()).min_by(order).unwrap() as u32
}

#[test]
fn the_long_side_is_found_however_the_object_lies() {
    for class in ObjectClass::ALL {
        let mesh = class.mesh(&Variation::NONE);
        let is_ball = class.name().ends_with("ball");
        let turn = Isometry3::new(Vector3::new(0.1, 0.0, 0.2), Vector3::new(0.4, -0.9, 0.2));
        let expected = if is_ball {
            Vector3::z()
        } else {
            turn * Vector3::z()
        };
        assert!((grasps(&mesh).long_axis().z - 1.0).abs() < 1e-6, "{class}");
        let axis = grasps(&mesh.transformed(&turn.cast())).long_axis();
        assert!(axis.angle(&expected) < 1e-3, "{class}: {axis:?}");
    }
}

#[test]
fn the_density_of_vertices_does_not_turn_the_long_side() {
    // One half of the rings are crowded into the lower tenth and on one side.
    let uneven = barrel(|_| 0.03, 0.12, 400, 64);
    let mut mesh = can();
    for vertex in &mut mesh.vertices {
        vertex.z = 0.12 * (vertex.z / 0.12).powi(3);
    }
    for mesh in [uneven, mesh] {
        assert!(grasps(&mesh).long_axis().angle(&Vector3::z()) < 1e-3);
    }
}

#[test]
fn a_given_long_side_is_taken_at_any_length() {
    let settings = GraspSettings {
        long_axis: Some(Unit::new_unchecked(Vector3::new(0.0, -2.0, 0.0))),
        ..GraspSettings::default()
    };
    let axis = Grasps::new(&can(), &settings).unwrap().long_axis();
    assert_eq!(axis.into_inner(), -Vector3::y());
}

#[test]
fn the_region_is_the_middle_and_the_ends_are_held() {
    let mesh = can();
    let grasps = grasps(&mesh);
    for (index, vertex) in mesh.vertices.iter().enumerate() {
        let is_inside = (vertex.z - 0.06).abs() <= 0.9 * 0.06;
        let index = index as u32;
        assert_eq!(grasps.held().contains(&index), !is_inside, "{vertex}");
        assert_eq!(grasps.region().contains(&index), is_inside, "{vertex}");
    }
    let expected = (0.035 * grasps.region().len() as f64).round() as usize;
    assert_eq!(grasps.default_count(), expected);
}

#[test]
fn an_order_is_a_permutation_that_its_seed_repeats() {
    let grasps = grasps(&can());
    let mut order = grasps.order(7);
    assert_eq!(order, grasps.order(7));
    assert_ne!(order, grasps.order(8));
    order.sort_unstable();
    assert_eq!(order, grasps.region());
}

#[test]
fn on_a_can_the_fingers_face_each_other() {
    let mesh = can();
    let grasps = grasps(&mesh);
    for &handle in grasps.region() {
        let grasp = grasps.grasp(handle).unwrap();
        assert_eq!(grasp.handles[0], handle);
        assert!((grasp.width_m - 0.06).abs() < 1e-6);
        assert!((grasp.intensity_max_m - 0.06 / 2.2).abs() < 1e-6);
        assert!((grasp.directions[0].dot(&grasp.directions[1]) + 1.0).abs() < 1e-6);
        let [first, second] = grasp.handles.map(|v| mesh.vertices[v as usize]);
        assert!(
            (first.z - second.z).abs() < 1e-6
                && (first.xy() + second.xy().coords).coords.norm() < 1e-6
        );
        // The pads are alike, touch at the handles, and hold nothing that is held.
        assert_eq!(grasp.patches[0].len(), grasp.patches[1].len());
        for (patch, gaps_m) in grasp.patches.iter().zip(&grasp.gaps_m) {
            assert_eq!((patch.len(), gaps_m[0]), (gaps_m.len(), 0.0));
            assert!(patch.iter().all(|v| !grasps.held().contains(v)));
            assert!(gaps_m.iter().all(|&gap_m| (0.0..0.0012).contains(&gap_m)));
        }
    }
}

#[test]
fn a_pad_is_as_wide_as_the_finger_and_presses_nearly_flat() {
    let mesh = can();
    let vertices_m: Vec<Point3<f64>> = mesh.vertices.iter().map(|v| v.cast()).collect();
    let grasp = grasps(&mesh).grasp(middle(&mesh, 0.06)).unwrap();
    let handle_m = vertices_m[grasp.handles[0] as usize];
    let patch = &grasp.patches[0];
    assert!(patch.len() > 10);
    for (index, vertex) in vertices_m.iter().enumerate() {
        let is_under = (vertex - handle_m).norm() <= 0.006;
        assert_eq!(patch.contains(&(index as u32)), is_under);
    }
    assert_eq!(
        grasp.targets_m(&vertices_m, 0.0),
        grasp
            .pressed()
            .iter()
            .map(|&v| vertices_m[v as usize])
            .collect::<Vec<_>>()
    );
    let targets_m = grasp.targets_m(&vertices_m, 0.004);
    assert!(
        ((targets_m[0] - handle_m).norm() - 0.004).abs() < 1e-12,
        "Eq. 4"
    );
    for (target_m, gap_m) in targets_m.iter().zip(&grasp.gaps_m[0]) {
        // The rest of the gap is left: the pad is soft.
        let depth_m = (target_m - handle_m).dot(&grasp.directions[0]);
        assert!((depth_m - 0.004 - 0.2 * gap_m).abs() < 1e-9);
    }
}

#[test]
fn the_order_of_vertices_does_not_matter() {
    let seed = 11;
    println!("seed {seed}");
    let mesh = ObjectClass::MediumCup.mesh(&Variation::random(1));
    let mut new_from_old: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    new_from_old.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
    let mut shuffled = mesh.clone();
    for (old, &new) in new_from_old.iter().enumerate() {
        shuffled.vertices[new as usize] = mesh.vertices[old];
    }
    for triangle in &mut shuffled.triangles {
        *triangle = triangle.map(|v| new_from_old[v as usize]);
    }
    let renamed = |vertices: &[u32]| -> HashSet<u32> {
        vertices.iter().map(|&v| new_from_old[v as usize]).collect()
    };
    let as_set = |vertices: &[u32]| -> HashSet<u32> { vertices.iter().copied().collect() };
    let (before, after) = (grasps(&mesh), grasps(&shuffled));
    assert_eq!(renamed(before.held()), as_set(after.held()));
    for handle in before.order(seed).into_iter().take(200) {
        let expected = before.grasp(handle);
        let found = after.grasp(new_from_old[handle as usize]);
        match (expected, found) {
            (Ok(expected), Ok(found)) => {
                assert_eq!(
                    expected.handles.map(|v| new_from_old[v as usize]),
                    found.handles
                );
                for (a, b) in expected.patches.iter().zip(&found.patches) {
                    assert_eq!(renamed(a), as_set(b));
                }
            }
            (expected, found) => assert_eq!(expected.is_err(), found.is_err()),
        }
    }
}

#[test]
fn a_cup_is_pressed_through_both_its_walls() {
    for class in [
        ObjectClass::SmallCup,
        ObjectClass::MediumCup,
        ObjectClass::LargeCup,
    ] {
        let mesh = class.mesh(&Variation::NONE);
        let grasps = grasps(&mesh);
        let height_m = 0.5 * mesh.bounds().1.z;
        let grasp = grasps.grasp(middle(&mesh, height_m)).unwrap();
        for (patch, direction) in grasp.patches.iter().zip(&grasp.directions) {
            let faces_in = |v: &&u32| grasps.surface.normals[**v as usize].dot(direction) > 0.0;
            let inner = patch.iter().filter(faces_in).count();
            assert!(
                inner > 0 && 2 * inner <= patch.len() + 4,
                "{class}: {inner}/{}",
                patch.len()
            );
        }
        let free_m = grasp.width_m - 2.2 * grasp.intensity_max_m;
        assert!((0.001..0.006).contains(&free_m), "{class}: {free_m}");
    }
}
