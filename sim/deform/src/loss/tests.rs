#![allow(clippy::unwrap_used)]
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};

use super::*;

fn of(source: &Mesh, vertices_m: &[Point3<f32>]) -> Loss {
    LossOfSource::new(source, &LossWeights::default()).of(vertices_m)
}

fn tetrahedron(side_m: f32) -> Mesh {
    let half = side_m / 8.0_f32.sqrt();
    let corners = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    Mesh {
        vertices: corners.map(|c| Point3::from(c) * half).to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    }
}

fn grid(count: u32, step_m: f32) -> Mesh {
    let side = count + 1;
    let at = |k| Point3::new((k % side) as f32 * step_m, (k / side) as f32 * step_m, 0.0);
    let corner = |x: u32, y: u32| y * side + x;
    let cell = |k: u32| {
        let (x, y) = (k % count, k / count);
        let [a, b] = [corner(x, y), corner(x + 1, y)];
        let [c, d] = [corner(x, y + 1), corner(x + 1, y + 1)];
        [[a, b, d], [a, d, c]]
    };
    Mesh {
        vertices: (0..side * side).map(at).collect(),
        triangles: (0..count * count).flat_map(cell).collect(),
    }
}

#[test]
fn a_regular_tetrahedron_has_its_closed_form() {
    let mesh = tetrahedron(0.012);
    let loss = of(&mesh, &mesh.vertices);
    assert!(loss.distance_mm2 < 1e-9);
    assert!((loss.edge_mm2 - 144.0).abs() < 1e-3, "{loss:?}");
    // Six edges; the normals of two faces are acos(-1/3) apart.
    assert!(
        (loss.normal - 6.0 * (1.0 + 1.0 / 3.0) / 4.0).abs() < 1e-6,
        "{loss:?}"
    );
    // A corner is the tetrahedron's height above the middle of the others.
    assert!(
        (loss.smooth_mm - 12.0 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-4,
        "{loss:?}"
    );
    let weighted = loss.distance_mm2 + loss.edge_mm2 + 0.01 * loss.normal + 0.1 * loss.smooth_mm;
    assert!((loss.total - weighted).abs() < 1e-12);
}

#[test]
fn the_printed_sums_meet_each_edge_twice_and_measure_it_against_the_mean() {
    let mesh = tetrahedron(0.012);
    let rest = of(&mesh, &mesh.vertices);
    assert!(rest.printed.edge_mm2 < 1e-6, "{rest:?}");
    assert_eq!(rest.printed.normal, 2.0 * rest.normal);
    // Twice as large: (24 − 12)² from both ends of each edge.
    let grown: Vec<Point3<f32>> = mesh.vertices.iter().map(|v| v * 2.0).collect();
    let loss = of(&mesh, &grown).printed;
    assert!((loss.edge_mm2 - 2.0 * 144.0).abs() < 1e-3, "{loss:?}");
    let distance_mm2 = of(&mesh, &grown).distance_mm2;
    let weighted = distance_mm2 + loss.edge_mm2 + 0.01 * loss.normal + 0.1 * loss.smooth_per_mm;
    assert!((loss.total - weighted).abs() < 1e-12);
}

#[test]
fn delta_is_twice_the_mean_curvature_and_its_mean_cancels() {
    let radius_mm = 30.0;
    let mesh = Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided();
    let vertices_mm: Vec<Point3<f64>> = mesh.vertices.iter().map(|v| v.cast() * 1e3).collect();
    let deltas = printed::deltas(&vertices_mm, &mesh.triangles);
    let middle = vertices_mm.iter().zip(&deltas).filter(|(place, _)| {
        (30.0..70.0).contains(&place.z) && place.x.hypot(place.y) > 0.99 * radius_mm
    });
    let mut count = 0;
    for (place, delta) in middle {
        // 1/r along the outward normal: a cylinder bends in one direction only. Its middles of chords lie on flat facets.
        let outward = Vector3::new(place.x, place.y, 0.0).normalize();
        assert!(delta.norm() < 2.5 / radius_mm, "{delta} at {place}");
        assert!(
            (delta - outward * delta.dot(&outward)).norm() < 1e-3,
            "{delta} at {place}"
        );
        count += 1;
    }
    assert!(count > 50);
    let loss = of(&mesh, &mesh.vertices);
    let mean = deltas.iter().map(|delta| delta.norm()).sum::<f64>() / deltas.len() as f64;
    assert!(loss.printed.smooth_per_mm < 0.05 * mean, "{loss:?}");
}

#[test]
fn edges_of_the_wanted_length_cost_nothing() {
    let mesh = tetrahedron(0.012);
    let weights = LossWeights {
        edge_target_m: 0.012,
        ..LossWeights::default()
    };
    let loss = LossOfSource::new(&mesh, &weights).of(&mesh.vertices);
    assert!(loss.edge_mm2 < 1e-6, "{loss:?}");
}

#[test]
fn a_plane_has_no_bends_and_is_smooth_inside() {
    let mesh = grid(10, 0.002);
    let loss = of(&mesh, &mesh.vertices);
    assert!(loss.normal < 1e-9, "{loss:?}");
    // 220 straight edges of 2 mm and 100 diagonals.
    assert!(
        (loss.edge_mm2 - (220.0 * 4.0 + 100.0 * 8.0) / 320.0).abs() < 1e-4,
        "{loss:?}"
    );
    let inside = LossOfSource::new(&mesh, &LossWeights::default());
    let vertices_mm: Vec<Point3<f64>> = mesh.vertices.iter().map(|v| v.cast() * 1e3).collect();
    // Only the rim is uneven: its vertices lie beside the mean of their neighbours.
    let rim_share = 40.0 / 121.0;
    assert!(inside.smooth_mm(&vertices_mm) < 2.0 * rim_share);
    // Folded along a grid line by a right angle, the ten edges on it each cost 1.
    let fold = |v: &Point3<f32>| Point3::new(v.x.min(0.01), v.y, (v.x - 0.01).max(0.0));
    let folded: Vec<Point3<f32>> = mesh.vertices.iter().map(fold).collect();
    assert!((of(&mesh, &folded).normal - 10.0 / 200.0).abs() < 1e-6);
}

#[test]
fn chamfer_distance_is_that_of_looking_at_every_pair() {
    let seed = 3;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let source = Mesh::cylinder(0.03, 0.0, 0.1, 32);
    let mut moved = source.vertices.clone();
    for vertex in &mut moved {
        *vertex += Vector3::from_fn(|_, _| random.random_range(-0.01..0.01));
    }
    let one_way = |from: &[Point3<f32>], to: &[Point3<f32>]| {
        let nearest = |p: &Point3<f32>| {
            to.iter()
                .map(|q| (p - q).cast::<f64>().norm_squared())
                .fold(f64::MAX, f64::min)
        };
        from.iter().map(nearest).sum::<f64>() / from.len() as f64 * 1e6
    };
    let expected = one_way(&source.vertices, &moved) + one_way(&moved, &source.vertices);
    let found = of(&source, &moved).distance_mm2;
    assert!(
        (found / expected - 1.0).abs() < 1e-5,
        "{found} instead of {expected}"
    );
}

#[test]
fn only_the_distance_tells_a_moved_object_from_one_at_rest() {
    let mesh = ObjectClass::SmallCup.mesh(&Variation::NONE);
    let rest = of(&mesh, &mesh.vertices);
    assert_eq!(rest.distance_mm2, 0.0);
    let motion = Isometry3::new(
        Vector3::new(0.001, 0.002, -0.001),
        Vector3::new(0.1, 0.2, 0.3),
    );
    let moved = of(&mesh, &mesh.transformed(&motion).vertices);
    assert!(moved.distance_mm2 > 0.1);
    assert!((moved.edge_mm2 / rest.edge_mm2 - 1.0).abs() < 1e-4);
    assert!((moved.normal - rest.normal).abs() < 1e-4);
    assert!((moved.smooth_mm / rest.smooth_mm - 1.0).abs() < 1e-4);
}

#[test]
fn weights_that_cannot_be_meant_are_named() {
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        let weights = LossWeights {
            normal: value,
            ..LossWeights::default()
        };
        let text = weights.validate().unwrap_err().to_string();
        assert!(
            text.contains("normal") && text.contains(&value.to_string()),
            "{text}"
        );
    }
    assert!(LossWeights::default().validate().is_ok());
}
