//! Registers random scans whose true poses are known, and writes what tests/peers/registration compares: one npz file
//! a scan, 000.npz, 001.npz, ...
//!
//! Specimens of all classes in turn, dented, 3 to 8 views, wrong camera mounts and joints, and a D435i's noise.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use candle_core::{Device, Tensor};
use clap::Parser;
use icp_registration::Registrar;
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, UnitSphere};
use rand_pcg::Pcg64Mcg;
use sim_objects::ObjectClass;
use sim_scan::{ScanParameters, Setup, View, capture};

/// Random scans with their true poses and with ours.
#[derive(Debug, Parser)]
struct Arguments {
    /// Where the files go
    folder: PathBuf,
    /// How many scans
    #[arg(long, default_value_t = 200)]
    scans: usize,
    /// Seed of the first scan; the next one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Largest error of the joints between wrist and camera, view by view.
const JOINT_ERROR_RAD: f64 = 0.25 * std::f64::consts::PI / 180.0;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    for number in 0..arguments.scans {
        let class = ObjectClass::ALL[number % ObjectClass::ALL.len()];
        let scan = Scan::random(class, arguments.seed + number as u64)?;
        let path = arguments.folder.join(format!("{number:03}.npz"));
        scan.write(&path)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Poses are hand_from_camera.
struct Scan {
    views: Vec<View>,
    truth: Vec<Isometry3<f64>>,
    registered: Vec<Registered>,
    /// Gripper and object in the hand's frame.
    mesh: Mesh,
}

struct Registered {
    pose: Isometry3<f64>,
    accepted: bool,
    milliseconds: f64,
}

impl Scan {
    fn random(class: ObjectClass, seed: u64) -> Result<Self> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let parameters = ScanParameters {
            view_count: random.random_range(3..=8),
            table_share: 0.0,
            undented_share: 0.0,
            ..ScanParameters::default()
        };
        let object = sim_scan::dented(class, &parameters, &mut random)?;
        let setup = Setup::random(&object, &parameters, &mut random);
        let mut views = capture(&setup, &mut random)?;
        for view in &mut views {
            view.believed_hand_from_camera =
                joint_error(&mut random) * view.believed_hand_from_camera;
        }
        let wrist_angles = setup.wrist_angles_rad.iter();
        Ok(Self {
            registered: register(&views)?,
            truth: wrist_angles
                .map(|&wrist_rad| setup.camera_from_hand(wrist_rad).inverse())
                .collect(),
            views,
            mesh: setup.scene.hand,
        })
    }

    fn write(&self, path: &Path) -> Result<()> {
        let points = self.views.iter().flat_map(|view| &view.points);
        let counts: Vec<u32> = self.views.iter().map(|v| v.points.len() as u32).collect();
        let believed = self.views.iter().map(|view| view.believed_hand_from_camera);
        let accepted: Vec<u32> = self.registered.iter().map(|r| r.accepted.into()).collect();
        let milliseconds: Vec<f64> = self.registered.iter().map(|r| r.milliseconds).collect();
        let triangles = self.mesh.triangles.concat();
        let shape = (triangles.len() / 3, 3);
        let arrays = [
            ("points", places(points)?),
            ("counts", Tensor::new(counts, &Device::Cpu)?),
            ("truth", matrices(self.truth.iter().copied())?),
            ("believed", matrices(believed)?),
            ("ours", matrices(self.registered.iter().map(|r| r.pose))?),
            ("ours_accepted", Tensor::new(accepted, &Device::Cpu)?),
            ("ours_ms", Tensor::new(milliseconds, &Device::Cpu)?),
            ("vertices", places(&self.mesh.vertices)?),
            (
                "triangles",
                Tensor::from_vec(triangles, shape, &Device::Cpu)?,
            ),
        ];
        Ok(Tensor::write_npz(&arrays, path)?)
    }
}

/// A turn about the hand's origin: joints between it and the camera are not quite where they say.
fn joint_error(random: &mut Pcg64Mcg) -> Isometry3<f64> {
    let axis: [f64; 3] = UnitSphere.sample(random);
    let turn = Vector3::from(axis) * random.random_range(0.0..=JOINT_ERROR_RAD);
    Isometry3::from_parts(
        Translation3::identity(),
        UnitQuaternion::from_scaled_axis(turn),
    )
}

/// With the robot's default settings; a view that cannot be registered stays where kinematics put it.
fn register(views: &[View]) -> Result<Vec<Registered>> {
    let mut registrar = Registrar::new(icp_registration::Parameters::default())?;
    let registered = views.iter().map(|view| {
        let believed = view.believed_hand_from_camera;
        let start = Instant::now();
        let evidence = registrar.add_view(&view.points, Some(believed));
        Registered {
            milliseconds: 1e3 * start.elapsed().as_secs_f64(),
            accepted: evidence.as_ref().is_ok_and(|evidence| evidence.accepted),
            pose: evidence.map_or(believed, |evidence| evidence.transform),
        }
    });
    Ok(registered.collect())
}

/// float32 [N, 3].
fn places<'a>(points: impl IntoIterator<Item = &'a Point3<f32>>) -> Result<Tensor> {
    let numbers: Vec<f32> = points
        .into_iter()
        .flat_map(|point| [point.x, point.y, point.z])
        .collect();
    let shape = (numbers.len() / 3, 3);
    Ok(Tensor::from_vec(numbers, shape, &Device::Cpu)?)
}

/// float64 [V, 4, 4].
fn matrices(poses: impl Iterator<Item = Isometry3<f64>>) -> Result<Tensor> {
    // nalgebra keeps columns together, numpy rows.
    let numbers: Vec<f64> = poses
        .flat_map(|pose| pose.to_homogeneous().transpose().as_slice().to_vec())
        .collect();
    let shape = (numbers.len() / 16, 4, 4);
    Ok(Tensor::from_vec(numbers, shape, &Device::Cpu)?)
}
