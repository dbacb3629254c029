//! After its first step, the search for a view's place allocates nothing: however long it goes on, registration takes
//! the same memory.

#![allow(clippy::expect_used)]

use std::alloc::System;

use cap::Cap;
use icp_registration::{Metric, Parameters, register};
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Points of a view.
const POINTS: usize = 3000;

fn main() {
    let seed = 5;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let views = [(); 2].map(|()| corner(&mut random));
    for (has_poses, metric) in [
        (false, Metric::Point),
        (true, Metric::Point),
        (true, Metric::Plane),
    ] {
        let [(short_bytes, short_steps), (long_bytes, long_steps)] =
            [1, 100].map(|max_iterations| cost(&views, has_poses, metric, max_iterations));
        println!("poses: {has_poses}, {metric:?}: {long_bytes} bytes for {long_steps} steps");
        assert!(long_steps > 2 * short_steps, "no more than {short_steps}");
        // With poses, views are compared after the search, in cells of an image: how many depends a little on where the steps
        // led. What allocated for its points at each step would take far more.
        let bytes_max = if has_poses {
            (long_steps - short_steps) * POINTS
        } else {
            0
        };
        assert!(
            long_bytes.abs_diff(short_bytes) <= bytes_max,
            "{long_steps} steps take {long_bytes} bytes, {short_steps} take {short_bytes}"
        );
    }
}

/// Bytes that registration allocates, freed or not, and the steps that it makes with the second view.
fn cost(
    views: &[Vec<Point3<f32>>; 2],
    has_poses: bool,
    metric: Metric,
    max_iterations: usize,
) -> (usize, usize) {
    let parameters = Parameters {
        metric,
        max_iterations,
        identity_max_iterations: max_iterations,
        // Refused in the end, the view leaves behind what does not depend on where the steps led.
        min_fitness: 1.0,
        ..Parameters::default()
    };
    let error = Isometry3::new(Vector3::new(0.003, -0.002, 0.001), Vector3::z() * 0.02);
    let placed = views
        .iter()
        .zip([Isometry3::identity(), error])
        .map(|(view, pose)| (&view[..], has_poses.then_some(pose)));
    let before = ALLOCATOR.total_allocated();
    let (_, evidence) = register(parameters, placed).expect("the views have a shape");
    let bytes = ALLOCATOR.total_allocated() - before;
    assert!(!evidence[1].accepted, "{:?}", evidence[1]);
    (bytes, evidence[1].iterations)
}

/// Points of three sides of a box, with noise, and one far away, m.
fn corner(random: &mut Pcg64Mcg) -> Vec<Point3<f32>> {
    let mut point = || {
        let mut place = Vector3::from_fn(|_, _| random.random_range(-0.03..0.03));
        place[random.random_range(0..3)] = 0.03 + random.random_range(-0.0005..0.0005);
        Point3::from(place + Vector3::z() * 0.15)
    };
    let mut points: Vec<_> = (0..POINTS).map(|_| point()).collect();
    points.insert(0, Point3::new(random.random_range(-0.1..0.1), 0.0, 0.3));
    points
}
