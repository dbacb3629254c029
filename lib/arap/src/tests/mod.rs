#![allow(clippy::unwrap_used)]

mod laws;
mod oracle;
mod printed;
mod refusals;
mod solves;

use std::f64::consts::TAU;

use mesh::Mesh;
use nalgebra::{Point3, Vector3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A dented tube with open rims, its vertices out of place by chance, so that some angles are obtuse.
pub(super) fn tube(seed: u64, around: usize, rings: usize) -> Mesh {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut place = |vertex: usize| {
        let mut jitter = || random.random_range(-0.3..0.3);
        let angle = TAU * ((vertex % around) as f64 + jitter()) / around as f64;
        let height = ((vertex / around) as f64 + jitter()) / rings as f64;
        let radius = 0.03 + 0.004 * (5.0 * height).sin() + 0.002 * jitter();
        Point3::new(radius * angle.cos(), radius * angle.sin(), 0.1 * height).cast()
    };
    let quad = |vertex: usize| {
        let next = vertex / around * around + (vertex + 1) % around;
        let [a, b, c, d] = [vertex, next, next + around, vertex + around].map(|index| index as u32);
        [[a, b, c], [a, c, d]]
    };
    Mesh {
        vertices: (0..rings * around).map(&mut place).collect(),
        triangles: (0..(rings - 1) * around).flat_map(quad).collect(),
    }
}

/// The first and the last ring of a tube.
pub(super) fn rims(around: usize, rings: usize) -> Vec<u32> {
    let last = (rings - 1) * around..rings * around;
    (0..around)
        .chain(last)
        .map(|vertex| vertex as u32)
        .collect()
}

/// Two opposite vertices of a tube's middle ring, and where they are when moved inward.
pub(super) fn pinch(mesh: &Mesh, around: usize, move_m: f64) -> ([u32; 2], [Point3<f64>; 2]) {
    let middle = mesh.vertices.len() / around / 2 * around;
    let handles = [middle, middle + around / 2].map(|vertex| vertex as u32);
    let inward = |handle: u32| {
        let place: Point3<f64> = mesh.vertices[handle as usize].cast();
        place - Vector3::new(place.x, place.y, 0.0).normalize() * move_m
    };
    (handles, handles.map(inward))
}

/// The same mesh with its vertices in another order: new index k was `order[k]`.
pub(super) fn shuffled(mesh: &Mesh, seed: u64) -> (Mesh, Vec<usize>) {
    let mut order: Vec<usize> = (0..mesh.vertices.len()).collect();
    order.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
    let mut names = vec![0; order.len()];
    order
        .iter()
        .enumerate()
        .for_each(|(name, &vertex)| names[vertex] = name as u32);
    let mesh = Mesh {
        vertices: order.iter().map(|&vertex| mesh.vertices[vertex]).collect(),
        triangles: mesh
            .triangles
            .iter()
            .map(|corners| corners.map(|vertex| names[vertex as usize]))
            .collect(),
    };
    (mesh, order)
}

/// The largest distance between places of the same index, in metres.
pub(super) fn apart_m(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, f64::max)
}
