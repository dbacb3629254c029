#![allow(clippy::unwrap_used)]
use super::*;

fn mesh(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
    Mesh {
        vertices: vertices.iter().map(|&place| place.into()).collect(),
        triangles: triangles.to_vec(),
    }
}

fn weight(rings: &OneRings, from: usize, to: usize) -> Option<f64> {
    rings
        .of(from)
        .find(|&(neighbour, _)| neighbour == to)
        .map(|(_, weight)| weight)
}

#[test]
fn an_edge_weighs_the_mean_of_the_cotangents_opposite() {
    // Two right triangles that share a side of 1: at its ends 90° and 45° are opposite to the other sides.
    let square = mesh(
        &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-2., 0., 0.]],
        &[[0, 1, 2], [0, 2, 3]],
    );
    let rings = OneRings::new(&square).unwrap();
    let near = |from, to, expected: f64| {
        let found = weight(&rings, from, to).unwrap();
        assert!((found - expected).abs() < 1e-6, "{from}-{to}: {found}");
        assert_eq!(weight(&rings, to, from), Some(found));
    };
    near(0, 2, (1.0 + 2.0) / 2.0);
    near(0, 1, 1.0);
    near(0, 3, 0.5);
    near(1, 2, 0.0);
    assert_eq!(weight(&rings, 1, 3), None);
    assert_eq!(square.area_m2(), 1.5);
}

#[test]
fn obtuse_and_flat_triangles_have_finite_weights_that_are_not_negative() {
    let flat = mesh(
        &[
            [0., 0., 0.],
            [1., 0., 0.],
            [0.5, 0.1, 0.],
            [0.25, 0., 0.],
            [0., 0., 0.],
        ],
        &[[0, 1, 2], [0, 1, 3], [0, 4, 1]],
    );
    let rings = OneRings::new(&flat).unwrap();
    let all: Vec<f64> = (0..5)
        .flat_map(|vertex| rings.of(vertex).map(|(_, weight)| weight))
        .collect();
    assert!(
        all.iter()
            .all(|weight| (WEIGHT_MIN..=triangle::COTANGENT_MAX).contains(weight)),
        "{all:?}"
    );
    assert_eq!(weight(&rings, 0, 1), Some(WEIGHT_MIN));
}

#[test]
fn renaming_keeps_the_edges() {
    let two = mesh(
        &[
            [0., 0., 0.],
            [5., 0., 0.],
            [1., 0., 0.],
            [6., 0., 0.],
            [0., 1., 0.],
            [5., 1., 0.],
        ],
        &[[0, 2, 4], [1, 3, 5]],
    );
    let rings = OneRings::new(&two).unwrap();
    let order = [3, 0, 5, 4, 1, 2];
    let renamed = rings.renamed(&order);
    for (from, &vertex) in order.iter().enumerate() {
        for (to, &other) in order.iter().enumerate() {
            assert_eq!(weight(&renamed, from, to), weight(&rings, vertex, other));
        }
    }
}
