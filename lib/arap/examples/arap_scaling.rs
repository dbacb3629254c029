//! How the time to factor and to deform grows with the number of vertices: CSV on stdout, exponents on stderr.

use std::f32::consts::TAU;
use std::time::Instant;

use arap::{Arap, ArapSettings};
use mesh::Mesh;
use nalgebra::{Point3, Vector3};

const VERTICES: [usize; 6] = [2_500, 5_000, 10_000, 25_000, 50_000, 100_000];
const RADIUS_M: f32 = 0.033;
const HEIGHT_M: f32 = 0.12;
const MOVE_M: f64 = 0.01;
/// Each figure is the least of so many.
const REPEATS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("vertices,factor_s,deform_s,iterations");
    let mut rows = Vec::new();
    for wanted in VERTICES {
        let (vertices, factor_s, deform_s, iterations) = measure(wanted)?;
        println!("{vertices},{factor_s:.5},{deform_s:.5},{iterations}");
        rows.push([vertices as f64, factor_s, deform_s].map(f64::ln));
    }
    for (column, name) in [(1, "factor"), (2, "deform")] {
        eprintln!(
            "{name}: time grows with vertices to the power {:.2}",
            exponent(&rows, column)
        );
    }
    Ok(())
}

fn measure(wanted: usize) -> Result<(usize, f64, f64, usize), Box<dyn std::error::Error>> {
    let (mesh, around) = tube(wanted);
    let rings = mesh.vertices.len() / around;
    let end = |ring: usize| ring < rings / 20 || ring >= rings - rings / 20;
    let held: Vec<u32> = (0..mesh.vertices.len())
        .filter(|vertex| end(vertex / around))
        .map(|v| v as u32)
        .collect();
    let middle = rings / 2 * around;
    let handles = [middle, middle + around / 2].map(|vertex| vertex as u32);
    let targets_m = handles.map(|handle| {
        let place: Point3<f64> = mesh.vertices[handle as usize].cast();
        place - Vector3::new(place.x, place.y, 0.0).normalize() * MOVE_M
    });
    let (mut factor_s, mut deform_s, mut iterations) = (f64::MAX, f64::MAX, 0);
    for _ in 0..REPEATS {
        let start = Instant::now();
        let arap = Arap::new(&mesh, &held, ArapSettings::default())?;
        factor_s = factor_s.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        iterations = arap.grip(&handles)?.deform(&targets_m)?.iterations;
        deform_s = deform_s.min(start.elapsed().as_secs_f64());
    }
    Ok((mesh.vertices.len(), factor_s, deform_s, iterations))
}

/// A can without lids, of nearly equilateral triangles, and how many vertices it has around.
fn tube(vertices: usize) -> (Mesh, usize) {
    let around = (vertices as f32 * TAU * RADIUS_M / HEIGHT_M).sqrt().round() as usize;
    let rings = vertices / around;
    let place = |vertex: usize| {
        let (ring, step) = (vertex / around, vertex % around);
        let angle = TAU * step as f32 / around as f32;
        let height_m = HEIGHT_M * ring as f32 / (rings - 1) as f32;
        Point3::new(RADIUS_M * angle.cos(), RADIUS_M * angle.sin(), height_m)
    };
    let quad = |vertex: usize| {
        let next = vertex / around * around + (vertex + 1) % around;
        let [a, b, c, d] = [vertex, next, next + around, vertex + around].map(|index| index as u32);
        [[a, b, c], [a, c, d]]
    };
    let mesh = Mesh {
        vertices: (0..rings * around).map(place).collect(),
        triangles: (0..(rings - 1) * around).flat_map(quad).collect(),
    };
    (mesh, around)
}

/// Slope of the straight line nearest to the logarithms.
fn exponent(rows: &[[f64; 3]], column: usize) -> f64 {
    let mean = |column: usize| rows.iter().map(|row| row[column]).sum::<f64>() / rows.len() as f64;
    let (x, y) = (mean(0), mean(column));
    let along: f64 = rows
        .iter()
        .map(|row| (row[0] - x) * (row[column] - y))
        .sum();
    along / rows.iter().map(|row| (row[0] - x).powi(2)).sum::<f64>()
}
