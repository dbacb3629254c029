//! Random clouds for tests.

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Points uniform in the cube of side `side_m` around the origin.
pub(crate) fn points(seed: u64, count: usize, side_m: f32) -> Vec<Point3<f32>> {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut coordinate = || random.random_range(-side_m / 2.0..side_m / 2.0);
    (0..count)
        .map(|_| Point3::new(coordinate(), coordinate(), coordinate()))
        .collect()
}
