#![allow(clippy::unwrap_used)]
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};

use super::*;

fn corners(mesh: &Mesh) -> Vec<Point3<f64>> {
    mesh.vertices.iter().map(|v| v.cast()).collect()
}

fn intersect(vertices_m: &[Point3<f64>], first: &[u32; 3], second: &[u32; 3]) -> bool {
    Triangles::new(vertices_m, &[*first, *second]).intersect(0, 1)
}

/// Oracle: every pair, without a tree.
fn all_pairs(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let count = triangles.len() as u32;
    (0..count)
        .flat_map(|a| (a + 1..count).map(move |b| [a, b]))
        .filter(|&[a, b]| intersect(vertices_m, &triangles[a as usize], &triangles[b as usize]))
        .collect()
}

#[test]
fn the_tree_finds_what_looking_at_every_pair_finds() {
    for seed in 0..20 {
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let source = Mesh::cylinder(0.03, 0.0, 0.1, 24);
        let intersections = SelfIntersections::of(&source);
        let mut vertices_m = corners(&source);
        for vertex in &mut vertices_m {
            *vertex += Vector3::from_fn(|_, _| random.random_range(-0.02..0.02));
        }
        let expected = all_pairs(&vertices_m, &source.triangles);
        assert!(
            !expected.is_empty(),
            "the fixture does not intersect itself"
        );
        assert_eq!(intersections.new_pairs(&vertices_m), expected);
    }
}

/// Oracle: two triangles without a common vertex meet where an edge of one passes through the other, found by solving for
/// the point instead of by signs.
fn solved(first: &[Point3<f64>; 3], second: &[Point3<f64>; 3]) -> bool {
    let crosses = |from: &[Point3<f64>; 3], to: &[Point3<f64>; 3]| {
        (0..3).any(|k| {
            let (start, end) = (from[k], from[(k + 1) % 3]);
            let columns = [to[1] - to[0], to[2] - to[0], start - end];
            let matrix = nalgebra::Matrix3::from_columns(&columns);
            matrix.lu().solve(&(start - to[0])).is_some_and(|x| {
                x.iter().all(|value| *value >= 0.0) && x[0] + x[1] <= 1.0 && x[2] <= 1.0
            })
        })
    };
    crosses(first, second) || crosses(second, first)
}

/// Checks pairs of triangles of random points against whether they intersect; both cases come often.
fn compare(
    seed: u64,
    point_count: usize,
    pairs: &[[[u32; 3]; 2]],
    expected: impl Fn(&[Point3<f64>]) -> bool,
) {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut hits = 0;
    for _ in 0..20_000 {
        let points: Vec<Point3<f64>> = (0..point_count)
            .map(|_| Point3::from([0; 3].map(|_| random.random())))
            .collect();
        let expected = expected(&points);
        for [first, second] in pairs {
            assert_eq!(intersect(&points, first, second), expected, "{points:?}");
        }
        hits += usize::from(expected);
    }
    assert!((1000..19_000).contains(&hits), "{hits} of 20,000");
}

#[test]
fn random_triangles_agree_with_solving_for_the_point() {
    let pairs = [[[0, 1, 2], [3, 4, 5]], [[4, 3, 5], [2, 1, 0]]];
    compare(5, 6, &pairs, |points| {
        solved(&[0, 1, 2].map(|k| points[k]), &[3, 4, 5].map(|k| points[k]))
    });
}

#[test]
fn triangles_that_share_a_vertex_meet_only_where_one_pierces_the_other() {
    compare(6, 5, &[[[1, 0, 2], [4, 3, 0]]], |points| {
        // Drawn back from the shared vertex, the pair has no vertex in common and stays as it was elsewhere.
        let apart = |k: usize| {
            points[0] + 1e-9 * (nalgebra::center(&points[k], &points[k + 1]) - points[0])
        };
        solved(
            &[apart(1), points[1], points[2]],
            &[apart(3), points[3], points[4]],
        )
    });
}

#[test]
fn neighbours_in_one_plane_intersect_only_when_folded_over() {
    let flat = |x: f64, y: f64| Point3::new(x, y, 0.3);
    let points = [
        flat(0.0, 0.0),
        flat(1.0, 0.0),
        flat(0.0, 1.0),
        flat(1.0, 1.0),
        flat(0.2, 0.3),
    ];
    assert!(!intersect(&points, &[0, 1, 2], &[2, 1, 3]), "side by side");
    assert!(
        intersect(&points, &[0, 1, 2], &[1, 2, 4]),
        "folded over an edge"
    );
    assert!(
        intersect(&points, &[0, 1, 2], &[0, 3, 4]),
        "overlap at a vertex"
    );
    assert!(!intersect(&points, &[0, 1, 2], &[1, 0, 2]), "listed twice");
    let apart = [flat(2.0, 0.0), flat(3.0, 0.0), flat(2.0, 1.0)];
    let points = [&points[..], &apart].concat();
    assert!(
        !intersect(&points, &[0, 1, 2], &[5, 6, 7]),
        "apart in the plane"
    );
    let inside = [flat(0.1, 0.1), flat(0.2, 0.1), flat(0.1, 0.2)];
    let points = [&points[..], &inside].concat();
    assert!(
        intersect(&points, &[0, 1, 2], &[8, 9, 10]),
        "one within the other"
    );
}

#[test]
fn the_parametric_objects_do_not_intersect_themselves() {
    for class in ObjectClass::ALL {
        let mesh = class.mesh(&Variation::NONE);
        assert_eq!(
            SelfIntersections::of(&mesh).source_pairs(),
            [[0; 2]; 0],
            "{class}"
        );
    }
}

#[test]
fn what_the_source_had_is_not_new() {
    let one = Mesh::cuboid(Point3::origin(), Point3::new(1.0, 1.0, 1.0));
    let mut two = one.clone();
    two.append(&one.transformed(&Isometry3::translation(0.5, 0.4, 0.3)));
    let intersections = SelfIntersections::of(&two);
    assert!(!intersections.source_pairs().is_empty());
    assert_eq!(intersections.new_pairs(&corners(&two)), [[0; 2]; 0]);
    // Pulled apart there is none; pushed in from another side there are others.
    let moved = |x, y, z| {
        let mut vertices_m = corners(&two);
        vertices_m[8..]
            .iter_mut()
            .for_each(|v| *v += Vector3::new(x, y, z));
        intersections.new_pairs(&vertices_m)
    };
    assert!(moved(2.0, 0.0, 0.0).is_empty());
    assert!(!moved(-0.8, 0.0, 0.0).is_empty());
}

#[test]
fn a_mesh_without_triangles_has_no_pairs() {
    let intersections = SelfIntersections::of(&Mesh::default());
    assert!(intersections.new_pairs(&[]).is_empty());
}
