use nalgebra::{Isometry3, Point3, Vector3};

use super::{apart_m, pinch, rims, shuffled, tube};
use crate::energy::Rotations;
use crate::minimise::{Places, State};
use crate::{Arap, ArapSettings, Stop};

const AROUND: usize = 24;
const RINGS: usize = 30;

fn exact(smoothness: f64) -> ArapSettings {
    ArapSettings {
        smoothness,
        energy_change_min: 1e-13,
        iterations_max: 3000,
    }
}

#[test]
fn a_rigid_motion_of_the_handles_costs_nothing_and_is_reproduced() {
    let mesh = tube(1, AROUND, RINGS);
    for smoothness in [0.01, 0.0] {
        let arap = Arap::new(&mesh, &[], exact(smoothness)).unwrap();
        let motion = Isometry3::new(Vector3::new(0.02, -0.01, 0.3), Vector3::new(0.4, -0.7, 0.5));
        let handles = [0, 200, 431, 700];
        let moved: Vec<Point3<f64>> = mesh
            .vertices
            .iter()
            .map(|place| motion * place.cast::<f64>())
            .collect();
        let targets_m = handles.map(|handle| moved[handle as usize]);
        let deformed = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
        assert!(
            deformed.energy_m2 < 1e-18,
            "{} m² after {:?}",
            deformed.energy_m2,
            deformed.stop
        );
        assert!(
            apart_m(&deformed.vertices_m, &moved) < 1e-7,
            "{}",
            apart_m(&deformed.vertices_m, &moved)
        );
    }
}

#[test]
fn one_handle_alone_takes_the_mesh_along() {
    let mesh = tube(2, AROUND, RINGS);
    let arap = Arap::new(&mesh, &[], ArapSettings::default()).unwrap();
    let way = Vector3::new(0.01, 0.02, -0.03);
    for handle in 0..mesh.vertices.len() as u32 {
        let target = mesh.vertices[handle as usize].cast() + way;
        let deformed = arap.grip(&[handle]).unwrap().deform(&[target]).unwrap();
        let expected: Vec<Point3<f64>> = mesh
            .vertices
            .iter()
            .map(|place| place.cast() + way)
            .collect();
        assert!(apart_m(&deformed.vertices_m, &expected) < 1e-12);
    }
}

#[test]
fn handles_end_where_asked_and_held_vertices_stay() {
    let mesh = tube(3, AROUND, RINGS);
    let held = rims(AROUND, RINGS);
    let arap = Arap::new(&mesh, &held, ArapSettings::default()).unwrap();
    let handles: Vec<u32> = (300..360).collect();
    let inward = |&handle: &u32| {
        let place: Point3<f64> = mesh.vertices[handle as usize].cast();
        Point3::new(0.8 * place.x, 0.7 * place.y, place.z + 0.003)
    };
    let targets_m: Vec<_> = handles.iter().map(inward).collect();
    let deformed = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
    for (&handle, target) in handles.iter().zip(&targets_m) {
        assert!((deformed.vertices_m[handle as usize] - target).norm() < 1e-12);
    }
    for vertex in held {
        assert_eq!(
            deformed.vertices_m[vertex as usize],
            mesh.vertices[vertex as usize].cast()
        );
    }
    assert_eq!(deformed.stop, Stop::EnergySettled);
}

/// The handles' rows are not only overwritten: without that the solve brings them to their targets, too.
#[test]
fn the_forces_balance_everywhere_but_at_the_constraints() {
    let mesh = tube(4, AROUND, RINGS);
    for held in [rims(AROUND, RINGS), Vec::new()] {
        let arap = Arap::new(&mesh, &held, ArapSettings::default()).unwrap();
        let (handles, targets_m) = pinch(&mesh, AROUND, 0.01);
        let mut grip = arap.grip(&handles).unwrap();
        grip.deform(&targets_m).unwrap();
        let (surface, state) = (&arap.surface, &grip.state);
        let mut pulls = vec![[0.0; 4]; mesh.vertices.len()];
        surface.pulls(&state.rotations, &mut pulls);
        for (vertex, pull) in pulls.iter().enumerate() {
            if arap.held[vertex] || grip.handles.vertices.contains(&vertex) {
                continue;
            }
            let mut force = -Vector3::new(pull[0], pull[1], pull[2]);
            for (neighbour, weight) in surface.rings.of(vertex) {
                force += (state.moved_m[vertex] - state.moved_m[neighbour]) * weight;
            }
            assert!(force.norm() < 1e-13, "vertex {vertex}: {force}");
        }
    }
}

#[test]
fn the_energy_never_rises() {
    for (seed, smoothness) in [(5, 0.01), (6, 0.0), (7, 1e-4), (8, 1.0)] {
        let mesh = tube(seed, AROUND, RINGS);
        let settings = ArapSettings {
            smoothness,
            ..Default::default()
        };
        let arap = Arap::new(&mesh, &rims(AROUND, RINGS), settings).unwrap();
        for move_m in [0.001, 0.014, 0.055] {
            let (handles, targets_m) = pinch(&mesh, AROUND, move_m);
            let deformed = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
            let energies = &deformed.energies_m2;
            assert!(
                energies.windows(2).all(|pair| pair[1] <= pair[0]),
                "{energies:?}"
            );
            assert_eq!(energies.len(), deformed.iterations + 1);
            assert_eq!(energies.last(), Some(&deformed.energy_m2));
            // What the places could have with the best rotations for them is no more, and hardly less.
            let least_m2 = arap.energy_m2(&deformed.vertices_m).unwrap();
            assert!(
                least_m2 <= deformed.energy_m2 * (1.0 + 1e-6),
                "{least_m2} {}",
                deformed.energy_m2
            );
        }
    }
}

#[test]
fn the_order_of_the_vertices_does_not_matter() {
    let mesh = tube(9, AROUND, RINGS);
    let held = rims(AROUND, RINGS);
    let (handles, targets_m) = pinch(&mesh, AROUND, 0.01);
    let deform = |mesh, held: &[u32], handles: &[u32]| {
        let arap = Arap::new(mesh, held, exact(0.01)).unwrap();
        arap.grip(handles).unwrap().deform(&targets_m).unwrap()
    };
    let straight = deform(&mesh, &held, &handles);
    let (other, order) = shuffled(&mesh, 10);
    let mut names = vec![0; order.len()];
    order
        .iter()
        .enumerate()
        .for_each(|(name, &vertex)| names[vertex] = name as u32);
    let renamed = |vertices: &[u32]| {
        vertices
            .iter()
            .map(|&vertex| names[vertex as usize])
            .collect::<Vec<_>>()
    };
    let crooked = deform(&other, &renamed(&held), &renamed(&handles));
    let back: Vec<_> = names
        .iter()
        .map(|&name| crooked.vertices_m[name as usize])
        .collect();
    assert!(
        apart_m(&straight.vertices_m, &back) < 1e-7,
        "{}",
        apart_m(&straight.vertices_m, &back)
    );
    assert!((straight.energy_m2 / crooked.energy_m2 - 1.0).abs() < 1e-9);
}

#[test]
fn going_on_from_the_last_targets_ends_where_a_fresh_start_does_and_sooner() {
    let mesh = tube(11, AROUND, RINGS);
    let settings = ArapSettings {
        energy_change_min: 1e-9,
        ..Default::default()
    };
    let arap = Arap::new(&mesh, &rims(AROUND, RINGS), settings).unwrap();
    let (handles, _) = pinch(&mesh, AROUND, 0.0);
    let mut grip = arap.grip(&handles).unwrap();
    for move_m in [0.004, 0.006, 0.008, 0.010, 0.012] {
        let (_, targets_m) = pinch(&mesh, AROUND, move_m);
        let warm = grip.deform(&targets_m).unwrap();
        let cold = arap.grip(&handles).unwrap().deform(&targets_m).unwrap();
        assert!((warm.energy_m2 / cold.energy_m2 - 1.0).abs() < 1e-6);
        assert!(apart_m(&warm.vertices_m, &cold.vertices_m) < 1e-5);
        assert!(
            move_m == 0.004 || warm.iterations < cold.iterations,
            "{} {}",
            warm.iterations,
            cold.iterations
        );
    }
}

#[test]
fn without_handles_nothing_moves() {
    let mesh = tube(13, AROUND, RINGS);
    let all: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for held in [&all[..], &all[..3]] {
        let arap = Arap::new(&mesh, held, ArapSettings::default()).unwrap();
        let deformed = arap.grip(&[]).unwrap().deform(&[]).unwrap();
        assert_eq!((deformed.energy_m2, deformed.iterations), (0.0, 0));
        let rest: Vec<Point3<f64>> = mesh.vertices.iter().map(|place| place.cast()).collect();
        assert_eq!(deformed.vertices_m, rest);
    }
}

/// Large meshes share the work of a deformation among threads.
#[test]
fn the_number_of_threads_does_not_show_in_a_single_bit() {
    for (seed, around, rings) in [(14, AROUND, RINGS), (15, 200, 170)] {
        let mesh = tube(seed, around, rings);
        let (handles, targets_m) = pinch(&mesh, around, 0.01);
        let deform = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let arap = Arap::new(&mesh, &rims(around, rings), ArapSettings::default()).unwrap();
                arap.grip(&handles).unwrap().deform(&targets_m).unwrap()
            })
        };
        assert_eq!(deform(1), deform(2));
    }
}

#[test]
fn the_slope_of_the_energy_is_that_of_differences() {
    let mesh = tube(12, 8, 6);
    let arap = Arap::new(&mesh, &rims(8, 6), ArapSettings::default()).unwrap();
    let (handles, targets_m) = pinch(&mesh, 8, 0.01);
    let mut grip = arap.grip(&handles).unwrap();
    grip.deform(&targets_m).unwrap();
    let count = mesh.vertices.len();
    let turned = |turns: &[Vector3<f64>], scale: f64| {
        let mut rotations = Rotations::identity(count);
        rotations.set_turned(&grip.state.rotations, turns, scale);
        rotations
    };
    // Away from the least energy, where the slope is not zero.
    let turns: Vec<_> = (0..count)
        .map(|k| Vector3::new(k as f64 % 3.0, 0.5, -(k as f64 % 2.0)) * 0.1)
        .collect();
    let start = turned(&turns, 1.0);
    let mut energy_of = |rotations: &Rotations| {
        let mut state = State::rest(count);
        grip.handles
            .settle(&arap.surface, rotations, &mut state.moved_m);
        let mut slopes = state.moved_m.clone();
        (
            arap.surface.energy(rotations, &state.moved_m, &mut slopes),
            slopes,
        )
    };
    let (_, slopes) = energy_of(&start);
    for vertex in 0..count {
        for axis in 0..3 {
            let mut turn = vec![Vector3::zeros(); count];
            turn[vertex][axis] = 1e-5;
            let mut energy_after = |scale: f64| {
                let mut rotations = start.clone();
                rotations.set_turned(&start, &turn, scale);
                energy_of(&rotations).0
            };
            let difference = (energy_after(1.0) - energy_after(-1.0)) / 2e-5;
            let slope = slopes[vertex][axis];
            assert!(
                (difference - slope).abs() < 1e-6 * slope.abs() + 1e-12,
                "{vertex}.{axis}: {difference} {slope}"
            );
        }
    }
}
