//! Simulated scans of objects whose every dent is known.

pub mod score;
pub mod unseen;

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use deformation::{Observation, Reference};
use icp_registration::Registrar;
use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use roi_crop::{Cropper, Frame};
use serde::{Deserialize, Serialize};
use sim_deform::{Denter, Flattening, Settings, specimen};
use sim_objects::{ObjectClass, Variation};
use sim_scan::{ScanParameters, Setup, capture};

/// Share of the hollow objects that are flattened instead of squeezed.
const FLATTENED_SHARE: f64 = 0.25;

/// A scan and what is true of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Case {
    pub class: String,
    pub seed: u64,
    /// 0 for an undented object.
    pub asked_m: f64,
    pub flattened: bool,
    /// From the camera to the object in the first view, m.
    pub distance_m: f64,
    /// In the frame of the registered cloud.
    pub points: Vec<Point3<f32>>,
    pub viewpoints: Vec<Point3<f64>>,
    /// Dents that cameras saw, the deepest first.
    pub truth: Vec<Truth>,
    /// The object's wall, seen or not.
    pub wall: Vec<Place>,
}

/// A place of the object's wall in the registered cloud's frame.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Place {
    /// Before it was dented.
    pub from: Point3<f32>,
    pub to: Point3<f32>,
    /// How far it was pressed in.
    pub depth_m: f32,
    pub seen: bool,
}

/// A dent that cameras saw.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Truth {
    pub depth_m: f64,
    /// Middle of what is deeper than 70 % of the depth, before the dent was pressed in, in the registered cloud's frame.
    pub centre: Point3<f64>,
    /// Outward there.
    pub direction: Vector3<f64>,
}

/// What dents an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pads {
    /// Both of a parallel gripper, by the same depth.
    Both,
    /// Only the first, as a corner that it is pushed against.
    One,
}

impl Pads {
    fn press(
        self,
        class: ObjectClass,
        variation: &Variation,
        depth_m: f64,
        seed: u64,
    ) -> Result<Mesh> {
        if self == Self::Both || depth_m == 0.0 {
            return Ok(specimen(class, variation, depth_m, seed)?);
        }
        let denter = Denter::new(class.mesh(&Variation::NONE), &Settings::default())?;
        let grasps = denter.grasps();
        for handle in grasps.order(seed) {
            let Ok(mut grasp) = grasps.grasp(handle) else {
                continue;
            };
            grasp.patches[1].clear();
            grasp.gaps_m[1].clear();
            if let Ok(dents) = denter.dent(&grasp, &[depth_m])
                && let Some(dent) = dents.into_iter().next()
            {
                let mut mesh = dent.mesh;
                variation.apply(&mut mesh);
                return Ok(mesh);
            }
        }
        anyhow::bail!("{class} cannot be dented")
    }
}

/// Depths that are asked for, in turn, as soon as each object has had the one before.
pub const DEPTHS_M: [f64; 4] = [0.0, 0.004, 0.008, 0.012];

impl Case {
    /// The one of a number among many; `None` where registration ends the scan, as the graph's then ends with an error.
    pub fn numbered(number: usize, first_seed: u64, pads: Pads) -> Result<Option<Self>> {
        let class = ObjectClass::ALL[number % ObjectClass::ALL.len()];
        let asked_m = DEPTHS_M[number / ObjectClass::ALL.len() % DEPTHS_M.len()];
        Self::simulate(class, asked_m, first_seed + number as u64, pads)
    }

    pub fn observation(&self) -> Observation<'_> {
        Observation {
            points: &self.points,
            up: Vector3::z(),
            viewpoints: &self.viewpoints,
            in_hand_frame: true,
        }
    }

    /// A held object, 4 views, a wrong camera mount and a D435i's noise.
    fn simulate(class: ObjectClass, asked_m: f64, seed: u64, pads: Pads) -> Result<Option<Self>> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let variation = Variation::random(random.random());
        let undented = class.mesh(&variation);
        let flattened = class.is_hollow() && random.random_bool(FLATTENED_SHARE) && asked_m > 0.0;
        let object = if flattened {
            let mut mesh = undented.clone();
            let height_m = mesh.bounds().1.z;
            Flattening::random(asked_m as f32, height_m, &mut random).apply(&mut mesh);
            mesh
        } else {
            pads.press(class, &variation, asked_m, random.random())?
        };
        let parameters = ScanParameters {
            table_share: 0.0,
            view_count: random.random_range(3..=5),
            ..ScanParameters::default()
        };
        let before = Setup::random(&undented, &parameters, &mut random.clone());
        let setup = Setup::random(&object, &parameters, &mut random);
        let views = capture(&setup, &mut random)?;
        let mut registrar = Registrar::new(parameters.registration.clone())?;
        let mut cloud_from_cameras = Vec::new();
        for view in &views {
            let added = registrar.add_view(&view.points, Some(view.believed_hand_from_camera));
            let Ok(evidence) = added else {
                return Ok(None);
            };
            cloud_from_cameras.push(evidence.transform);
        }
        let camera_from_hand = setup.camera_from_hand(setup.wrist_angles_rad[0]);
        let cloud_from_hand = *cloud_from_cameras.first().context("no views")? * camera_from_hand;
        let cropped = Cropper::new(setup.crop.clone())?
            .crop(&registrar.cloud(), Frame::Hand { opening_m: None })?;
        let count = object.vertices.len();
        let placed = |setup: &Setup| {
            let hand = &setup.scene.hand.vertices;
            hand[hand.len() - count..].to_vec()
        };
        let (from, to) = (placed(&before), placed(&setup));
        let places = places(
            &from,
            &to,
            &object.triangles,
            &cropped.points,
            &cloud_from_hand,
        );
        Ok(Some(Self {
            class: class.name().to_owned(),
            seed,
            asked_m,
            flattened,
            distance_m: (camera_from_hand * Point3::new(0.0, 0.0, 0.2)).z,
            truth: truth(&places),
            wall: wall(places, &cloud_from_hand.inverse()),
            points: cropped.points,
            viewpoints: cloud_from_cameras
                .iter()
                .map(|pose| Point3::from(pose.translation.vector))
                .collect(),
        }))
    }
}

/// What became of each vertex.
fn places(
    from: &[Point3<f32>],
    to: &[Point3<f32>],
    triangles: &[[u32; 3]],
    cloud: &[Point3<f32>],
    cloud_from_hand: &Isometry3<f64>,
) -> Vec<(Place, Vector3<f64>)> {
    const SEEN_M: f32 = 0.003;
    let mut normals = vec![Vector3::zeros(); from.len()];
    for &[a, b, c] in triangles {
        let [p, q, r] = [a, b, c].map(|index| from[index as usize]);
        let normal = (q - p).cross(&(r - p));
        [a, b, c]
            .iter()
            .for_each(|&index| normals[index as usize] += normal);
    }
    let tree = cloud::Tree::new(cloud);
    let is_seen = |place: &Point3<f32>| {
        let nearest = tree.as_ref().map(|tree| tree.nearest(place));
        nearest.is_some_and(|nearest| nearest.distance_sq < SEEN_M * SEEN_M)
    };
    let place = |((from, to), normal): ((&Point3<f32>, &Point3<f32>), &Vector3<f32>)| {
        let normal: Vector3<f64> = normal.cast::<f64>().normalize();
        let depth_m = -normal.dot(&(to - from).cast());
        let in_cloud = |place: &Point3<f32>| (cloud_from_hand * place.cast::<f64>()).cast();
        let place = Place {
            from: in_cloud(from),
            to: in_cloud(to),
            depth_m: depth_m as f32,
            seen: is_seen(&in_cloud(to)),
        };
        (place, cloud_from_hand * normal)
    };
    from.iter().zip(to).zip(&normals).map(place).collect()
}

/// Dents among the places that were seen.
fn truth(places: &[(Place, Vector3<f64>)]) -> Vec<Truth> {
    let seen = places
        .iter()
        .filter(|(place, _)| place.seen && place.depth_m > 0.0005);
    dents(
        seen.map(|(place, normal)| (f64::from(place.depth_m), place.from.cast(), *normal))
            .collect(),
    )
}

/// The outside of the wall: what faces away from the hand's axis.
fn wall(places: Vec<(Place, Vector3<f64>)>, hand_from_cloud: &Isometry3<f64>) -> Vec<Place> {
    let is_outside = |(place, normal): &(Place, Vector3<f64>)| {
        let (place, normal) = (
            hand_from_cloud * place.from.cast::<f64>(),
            hand_from_cloud * normal,
        );
        normal.x * place.x + normal.y * place.y > 0.5 * place.x.hypot(place.y)
    };
    let outside = places.into_iter().filter(is_outside);
    outside.map(|(place, _)| place).collect()
}

/// Deepest place first, each with what is around it.
fn dents(mut all: Vec<(f64, Point3<f64>, Vector3<f64>)>) -> Vec<Truth> {
    const SAME_DENT_M: f64 = 0.03;
    let mut found: Vec<Truth> = Vec::new();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    while let Some(&(depth_m, place, _)) = all.first() {
        let (mut centre, mut direction, mut weights) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (depth, at, normal) in &all {
            if *depth >= 0.7 * depth_m && (at - place).norm() < SAME_DENT_M {
                centre += at.coords * *depth;
                direction += normal * *depth;
                weights += depth;
            }
        }
        found.push(Truth {
            depth_m,
            centre: Point3::from(centre / weights),
            direction: direction.normalize(),
        });
        all.retain(|(_, at, _)| (at - place).norm() > SAME_DENT_M);
    }
    found
}

/// The eight objects, undented, by name.
pub fn references() -> Result<BTreeMap<&'static str, Reference>> {
    let prepared = |class: ObjectClass| {
        let mesh = class.mesh(&Variation::NONE);
        Ok((class.name(), Reference::new(class.name(), &mesh)?))
    };
    ObjectClass::ALL.into_iter().map(prepared).collect()
}
