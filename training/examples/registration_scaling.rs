//! How registration's time grows with points and with views, for tests/peers/registration: prints one JSON object.

use std::time::Instant;

use anyhow::Result;
use icp_registration::{Parameters, Registrar};
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use sim_objects::{ObjectClass, Variation};

const POINTS: [usize; 7] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000];
const VIEWS: [usize; 6] = [2, 4, 8, 16, 24, 36];
/// Points of a view where the number of views grows.
const VIEW_POINTS: usize = 7_000;
const NOISE_M: f32 = 0.0006;
const ROUNDS: usize = 5;

fn main() -> Result<()> {
    let seed = 1;
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let object = ObjectClass::MediumCup.mesh(&Variation::random(seed));
    let mut by_points = Vec::new();
    for points in POINTS {
        by_points.push(time(&object, points, 2, "points", &mut random)?);
    }
    let mut by_views = Vec::new();
    for views in VIEWS {
        by_views.push(time(&object, VIEW_POINTS, views, "views", &mut random)?);
    }
    println!(
        "{}",
        json!({"seed": seed, "by_points": by_points, "by_views": by_views})
    );
    Ok(())
}

/// The median time of a whole scan, ms, by kinematics and (without them) from identity.
fn time(
    object: &Mesh,
    points: usize,
    views: usize,
    what: &str,
    random: &mut Pcg64Mcg,
) -> Result<Value> {
    let clouds: Vec<_> = (0..views)
        .map(|_| cloud(object, points, random))
        .collect::<Result<_>>()?;
    let errors: Vec<_> = (0..views).map(|_| error(random)).collect();
    let mut kinematic = Vec::new();
    let mut identity = Vec::new();
    for _ in 0..ROUNDS {
        kinematic.push(scan(&clouds, |index| Some(errors[index]))?);
        identity.push(scan(&clouds, |_| None)?);
    }
    let count = if what == "points" { points } else { views };
    Ok(json!({what: count, "kinematic_ms": median(kinematic), "identity_ms": median(identity)}))
}

fn scan(
    clouds: &[Vec<Point3<f32>>],
    pose: impl Fn(usize) -> Option<Isometry3<f64>>,
) -> Result<f64> {
    let mut registrar = Registrar::new(Parameters::default())?;
    let start = Instant::now();
    for (index, cloud) in clouds.iter().enumerate() {
        registrar.add_view(cloud, pose(index))?;
    }
    Ok(1e3 * start.elapsed().as_secs_f64())
}

/// Points all over the object as the hand holds it, with a camera's noise.
fn cloud(object: &Mesh, points: usize, random: &mut Pcg64Mcg) -> Result<Vec<Point3<f32>>> {
    let noise = Normal::new(0.0, NOISE_M)?;
    let held = object.transformed(&Translation3::new(0.0, 0.0, 0.1277).into());
    let mut cloud = held.surface_points(points, random);
    for point in &mut cloud {
        *point += Vector3::from_fn(|_, _| noise.sample(random));
    }
    Ok(cloud)
}

/// A few millimetres and a degree off.
fn error(random: &mut Pcg64Mcg) -> Isometry3<f64> {
    let mut within = |limit: f64| Vector3::from_fn(|_, _| random.random_range(-limit..limit));
    Isometry3::from_parts(
        Translation3::from(within(0.003)),
        UnitQuaternion::from_scaled_axis(within(0.01)),
    )
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
