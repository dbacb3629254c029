//! Scans of known shapes, and distances from them.
#![allow(dead_code)]

use mesh::Mesh;
use mesh::file::Scan;
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Points spread evenly over a mesh, moved by noise of up to `noise_m` along the normal, with the true normals.
pub fn scan_of(mesh: &Mesh, count: usize, noise_m: f32, seed: u64) -> Scan {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut summed = 0.0;
    let areas: Vec<f32> = mesh
        .triangles
        .iter()
        .map(|&corners| {
            summed += area_normal(mesh, corners).norm();
            summed
        })
        .collect();
    let mut scan = Scan::default();
    let mut normals = Vec::new();
    for _ in 0..count {
        let wanted = random.random_range(0.0..summed);
        let triangle = areas.partition_point(|&area| area <= wanted);
        let corners = mesh.triangles[triangle.min(areas.len() - 1)];
        let normal = area_normal(mesh, corners).normalize();
        let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize]);
        let (mut u, mut v): (f32, f32) = (random.random(), random.random());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let noise = normal * random.random_range(-1.0..1.0) * noise_m;
        scan.points_m.push(a + (b - a) * u + (c - a) * v + noise);
        normals.push(normal);
    }
    scan.normals = Some(normals);
    scan
}

fn area_normal(mesh: &Mesh, corners: [u32; 3]) -> Vector3<f32> {
    let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize]);
    (b - a).cross(&(c - a))
}

/// The scan without its normals.
pub fn without_normals(scan: &Scan) -> Scan {
    Scan {
        normals: None,
        ..scan.clone()
    }
}

/// A ball about the origin with nearly equal triangles.
pub fn ball(radius_m: f32) -> Mesh {
    let outline: Vec<[f32; 2]> = (0..=96)
        .map(|step| std::f32::consts::PI * (step as f32 / 96.0 - 0.5))
        .map(|angle| [radius_m * angle.cos().max(0.0), radius_m * angle.sin()])
        .collect();
    let mut outline = outline;
    outline[0][0] = 0.0;
    outline[96][0] = 0.0;
    mesh::revolve(&outline, 192)
}

/// Root mean square and greatest of some distances.
pub fn rms_and_max(distances: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let (mut sum, mut count, mut max) = (0.0, 0.0, 0.0_f64);
    for distance in distances {
        sum += distance * distance;
        count += 1.0;
        max = max.max(distance.abs());
    }
    (f64::sqrt(sum / count), max)
}

/// RMS and greatest distance of every `step`-th vertex of one mesh from the surface of another.
pub fn distances(from: &Mesh, to: &Mesh, step: usize) -> (f64, f64) {
    let nearest = |vertex: &Point3<f32>| {
        let all = to.triangles.iter().map(|&corners| {
            let corners = corners.map(|corner| to.vertices[corner as usize].cast());
            distance(vertex.cast(), corners)
        });
        all.fold(f64::INFINITY, f64::min)
    };
    rms_and_max(from.vertices.iter().step_by(step).map(nearest))
}

/// Distance of a point from a triangle: from its plane, if the foot is inside, or else from its nearest side.
fn distance(point: Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let sides = [(a, b), (b, c), (c, a)];
    let is_left = |&(from, to): &(Point3<f64>, Point3<f64>)| {
        (to - from).cross(&(point - from)).dot(&normal) >= 0.0
    };
    if sides.iter().all(is_left) && normal.norm() > 0.0 {
        return ((point - a).dot(&normal) / normal.norm()).abs();
    }
    let to_side = |&(from, to): &(Point3<f64>, Point3<f64>)| {
        let along = to - from;
        let share = ((point - from).dot(&along) / along.norm_squared().max(1e-30)).clamp(0.0, 1.0);
        (point - (from + along * share)).norm()
    };
    sides.iter().map(to_side).fold(f64::INFINITY, f64::min)
}
