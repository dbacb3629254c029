//! Deforms a mesh as a JSON document on stdin asks, and answers with one on stdout; for tests/peers.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::Context;
use arap::{Arap, ArapError, ArapSettings, Deformed};
use mesh::Mesh;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Task {
    vertices_m: Vec<Point3<f32>>,
    triangles: Vec<[u32; 3]>,
    held: Vec<u32>,
    grasps: Vec<Grasp>,
    /// Places of all vertices whose energies are wanted.
    #[serde(default)]
    shapes_m: Vec<Vec<Point3<f64>>>,
    /// Grasps to time with all workers busy; they are taken in turn.
    #[serde(default)]
    timed: usize,
    #[serde(default = "two")]
    workers: usize,
    smoothness: Option<f64>,
    energy_change_min: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Grasp {
    handles: Vec<u32>,
    /// Where the handles go, one after the other; each starts from the one before.
    series_m: Vec<Vec<Point3<f64>>>,
}

#[derive(Serialize)]
struct Answer {
    factor_s: f64,
    /// By grasp, and by place in its series.
    deformed: Vec<Vec<Shape>>,
    shape_energies_m2: Vec<f64>,
    /// With all workers busy.
    meshes_per_s: f64,
}

#[derive(Serialize)]
struct Shape {
    vertices_m: Vec<Point3<f64>>,
    energy_m2: f64,
    energies_m2: Vec<f64>,
    iterations: usize,
    stop: String,
    /// On one core, the handles' preparation included.
    seconds: f64,
}

fn two() -> usize {
    2
}

fn main() -> anyhow::Result<()> {
    let task: Task =
        serde_json::from_reader(std::io::stdin().lock()).context("stdin is no task")?;
    let settings = ArapSettings {
        smoothness: task
            .smoothness
            .unwrap_or(ArapSettings::default().smoothness),
        energy_change_min: task
            .energy_change_min
            .unwrap_or(ArapSettings::default().energy_change_min),
        ..ArapSettings::default()
    };
    let mesh = Mesh {
        vertices: task.vertices_m,
        triangles: task.triangles,
    };
    Arap::new(&mesh, &task.held, settings)?;
    let start = Instant::now();
    let arap = Arap::new(&mesh, &task.held, settings)?;
    let factor_s = start.elapsed().as_secs_f64();
    let deformed = task
        .grasps
        .iter()
        .map(|grasp| shapes(&arap, grasp))
        .collect::<Result<_, _>>()?;
    let energies = task
        .shapes_m
        .iter()
        .map(|places_m| arap.energy_m2(places_m));
    let answer = Answer {
        factor_s,
        deformed,
        shape_energies_m2: energies.collect::<Result<_, _>>()?,
        meshes_per_s: rate(&arap, &task.grasps, task.timed, task.workers)?,
    };
    serde_json::to_writer(std::io::stdout().lock(), &answer)?;
    Ok(())
}

/// A grasp's deformations, the first from an untouched source, and the seconds that each took on one core.
fn deform(arap: &Arap, grasp: &Grasp) -> Result<Vec<(Deformed, f64)>, ArapError> {
    let mut start = Instant::now();
    let mut grip = arap.grip(&grasp.handles)?;
    let mut series = Vec::new();
    for targets_m in &grasp.series_m {
        let deformed = grip.deform(targets_m)?;
        series.push((deformed, start.elapsed().as_secs_f64()));
        start = Instant::now();
    }
    Ok(series)
}

fn shapes(arap: &Arap, grasp: &Grasp) -> Result<Vec<Shape>, ArapError> {
    let shape = |(deformed, seconds): (Deformed, f64)| Shape {
        seconds,
        vertices_m: deformed.vertices_m,
        energy_m2: deformed.energy_m2,
        energies_m2: deformed.energies_m2,
        iterations: deformed.iterations,
        stop: format!("{:?}", deformed.stop),
    };
    Ok(deform(arap, grasp)?.into_iter().map(shape).collect())
}

/// Meshes a second while each worker deforms one after the other.
fn rate(arap: &Arap, grasps: &[Grasp], timed: usize, workers: usize) -> anyhow::Result<f64> {
    let next = AtomicUsize::new(0);
    let work = || -> Result<usize, ArapError> {
        let mut meshes = 0;
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= timed {
                return Ok(meshes);
            }
            meshes += deform(arap, &grasps[index % grasps.len()])?.len();
        }
    };
    let start = Instant::now();
    let meshes: usize = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let meshes = threads.into_iter().map(|thread| match thread.join() {
            Ok(result) => result.map_err(anyhow::Error::from),
            Err(_) => anyhow::bail!("a worker panicked"),
        });
        meshes.sum::<anyhow::Result<usize>>()
    })?;
    Ok(meshes as f64 / start.elapsed().as_secs_f64())
}
