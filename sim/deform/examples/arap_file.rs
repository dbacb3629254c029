//! Deforms a mesh as a JSON document on stdin asks, and answers with one on stdout; for tests/peers.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::Context;
use nalgebra::Point3;
use serde::{Deserialize, Serialize};
use sim_deform::arap::{Arap, ArapError, ArapSettings, Deformed};
use sim_objects::Mesh;

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
    targets_m: Vec<Point3<f64>>,
}

#[derive(Serialize)]
struct Answer {
    factor_s: f64,
    deformed: Vec<Shape>,
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
        .map(|grasp| shape(&arap, grasp))
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

/// From an untouched source, as each grasp is when it is the first of its handles.
fn deform(arap: &Arap, grasp: &Grasp) -> Result<Deformed, ArapError> {
    arap.grip(&grasp.handles)?.deform(&grasp.targets_m)
}

fn shape(arap: &Arap, grasp: &Grasp) -> Result<Shape, ArapError> {
    let start = Instant::now();
    let deformed = deform(arap, grasp)?;
    Ok(Shape {
        seconds: start.elapsed().as_secs_f64(),
        vertices_m: deformed.vertices_m,
        energy_m2: deformed.energy_m2,
        energies_m2: deformed.energies_m2,
        iterations: deformed.iterations,
        stop: format!("{:?}", deformed.stop),
    })
}

/// Meshes a second while each worker deforms one after the other.
fn rate(arap: &Arap, grasps: &[Grasp], timed: usize, workers: usize) -> anyhow::Result<f64> {
    let next = AtomicUsize::new(0);
    let work = || -> Result<(), ArapError> {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= timed {
                return Ok(());
            }
            deform(arap, &grasps[index % grasps.len()])?;
        }
    };
    let start = Instant::now();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .try_for_each(|thread| match thread.join() {
                Ok(result) => result.map_err(anyhow::Error::from),
                Err(_) => anyhow::bail!("a worker panicked"),
            })
    })?;
    Ok(timed as f64 / start.elapsed().as_secs_f64())
}
