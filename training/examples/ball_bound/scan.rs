//! How the depth image of a scan changes with everything that is unknown about it.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use mesh::{Mesh, triangle};
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_camera::{OBJECT_BOTTOM_Z_M, Placement, Renderer};
use sim_deform::Denter;
use sim_objects::Variation;
use sim_scan::{ScanParameters, Setup};

use super::{BALLS, Covariance, Dent, VIEWS};

/// Unknowns: width, height, the dent's depth and height; turn and move of the ball in the hand; turn and move of the camera.
const UNKNOWNS: usize = 16;
const DENT: std::ops::Range<usize> = 2..4;
const IN_HAND: usize = 4;
const MOUNT: usize = 10;
/// What is seen at a smaller cosine between normal and line of sight counts as not seen: there, pixels are dropped or mixed.
const LEAST_COSINE: f64 = 0.2;
/// Depth is rounded to millimetres.
const ROUNDING_M: f64 = 0.001 / 3.464;
/// Pixels that share the correlated part of the noise: 4 x 4.
const PATCH_PX: f64 = 16.0;
/// What a dent moves by more counts as dented, m.
const DENTED_M: f64 = 0.0003;

/// One specimen before the camera, and how its surface moves with each unknown.
pub struct Scan {
    ball: usize,
    setup: Setup,
    /// In the hand's frame.
    surface: Mesh,
    undented: Mesh,
    /// Moves by unit of each unknown that belongs to the ball; of the dent's only where there is one.
    moves: Vec<Option<Vec<Vector3<f64>>>>,
}

impl Scan {
    /// A held scan of a traced ball, as `evaluate` makes them.
    ///
    /// # Errors
    /// The ball cannot be dented.
    pub fn random(ball: usize, denter: &Denter, seed: u64) -> Result<Self> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let parameters = ScanParameters {
            view_count: VIEWS,
            table_share: 0.0,
            ..ScanParameters::default()
        };
        let size = Variation::random(random.random());
        let is_dented = !random.random_bool(parameters.undented_share);
        let [least_m, most_m] = parameters.squeeze_m;
        let depth_m = random.random_range(least_m..=most_m);
        let order = denter.grasps().order(random.random());
        let grasp_of = |handle: u32| denter.grasps().grasp(handle).ok();
        let dent = |handle: u32, depth_m: f64| -> Option<Mesh> {
            let dents = denter.dent(&grasp_of(handle)?, &[depth_m]).ok()?;
            dents.into_iter().next().map(|dent| dent.mesh)
        };
        let undented = denter.source().clone();
        let (mesh, deeper, higher) = if is_dented {
            let (handle, mesh) = order
                .iter()
                .find_map(|&handle| Some((handle, dent(handle, depth_m)?)))
                .context("the ball cannot be dented")?;
            const STEP_M: f64 = 0.001;
            let deeper =
                dent(handle, depth_m - STEP_M).map(|shallower| (mesh.clone(), shallower, STEP_M));
            let (above, step_m) = above(&undented, &order, handle).context("no vertex above")?;
            let higher = dent(above, depth_m).map(|above| (above, mesh.clone(), step_m));
            (mesh, deeper, higher)
        } else {
            (undented.clone(), None, None)
        };
        // All meshes are grasped alike: the same numbers are drawn for each.
        let seed = random.random();
        let setup = |mesh: &Mesh, size: &Variation| {
            let mut mesh = mesh.clone();
            size.apply(&mut mesh);
            Setup::random(&mesh, &parameters, &mut Pcg64Mcg::seed_from_u64(seed))
        };
        let in_hand = |mesh: &Mesh, size: &Variation| object(&setup(mesh, size), mesh);
        let surface = in_hand(&mesh, &size);
        let apart = |to: &Mesh, from: &Mesh, by: f64| -> Vec<Vector3<f64>> {
            let pairs = to.vertices.iter().zip(&from.vertices);
            pairs
                .map(|(to, from)| (to - from).cast::<f64>() / by)
                .collect()
        };
        let [width_m, height_m] = BALLS[ball].size_m().map(f64::from);
        const GROWTH: f32 = 0.01;
        let grown = |width: f32, height: f32| {
            let size = Variation {
                width_scale: size.width_scale + width,
                height_scale: size.height_scale + height,
            };
            in_hand(&mesh, &size)
        };
        let growth = f64::from(GROWTH);
        let by_dent = |change: Option<(Mesh, Mesh, f64)>| {
            change.map(|(to, from, by)| apart(&in_hand(&to, &size), &in_hand(&from, &size), by))
        };
        let moves = vec![
            Some(apart(&grown(GROWTH, 0.0), &surface, growth * width_m)),
            Some(apart(&grown(0.0, GROWTH), &surface, growth * height_m)),
            by_dent(deeper),
            by_dent(higher),
        ];
        Ok(Self {
            ball,
            setup: setup(&mesh, &size),
            undented: in_hand(&undented, &size),
            surface,
            moves,
        })
    }

    /// The least that any unbiased estimate of the size errs by, from the first views: from all pixels, or from so many of
    /// them as if chosen by chance.
    pub fn covariance(&self, views: usize, dent: Dent, points: Option<f64>) -> Covariance {
        let mut information = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
        let mut renderer = Renderer::new(self.setup.camera.clone());
        let mut pixels = 0.0;
        for &wrist_rad in self.setup.wrist_angles_rad.iter().take(views) {
            let alike_px = if points.is_some() { 1.0 } else { PATCH_PX };
            pixels += self.look(&mut renderer, wrist_rad, dent, alike_px, &mut information);
        }
        information *= points.map_or(1.0, |points| (points / pixels).min(1.0));
        information += DMatrix::from_diagonal(&prior());
        if dent != Dent::Unknown {
            for index in DENT {
                information[(index, index)] += 1e12;
            }
        }
        let covariance = information
            .try_inverse()
            .unwrap_or_else(|| DMatrix::identity(UNKNOWNS, UNKNOWNS));
        Covariance {
            ball: self.ball,
            of_size_m2: covariance.fixed_view::<2, 2>(0, 0).into_owned(),
        }
    }

    /// Adds what one view tells, and returns how many pixels show the ball. Of so many neighbours the correlated part of the noise
    /// is the same.
    fn look(
        &self,
        renderer: &mut Renderer,
        wrist_rad: f64,
        dent: Dent,
        alike_px: f64,
        information: &mut DMatrix<f64>,
    ) -> f64 {
        let mut seen_px = 0.0;
        let camera_from_hand = self.setup.camera_from_hand(wrist_rad);
        let placement = Placement {
            camera_from_hand,
            camera_from_links: Vec::new(),
            camera_from_base: None,
        };
        let image = renderer.render(&self.setup.scene, &placement);
        let camera = &self.setup.camera;
        let middle = self.middle();
        for corners in &self.surface.triangles {
            let places = self.surface.corners(corners);
            let (normal, area_m2) = (triangle::normal(places), triangle::area(places));
            let place = Point3::from(places.iter().map(|p| p.coords).sum::<Vector3<f64>>() / 3.0);
            if !is_kept(&place) {
                continue;
            }
            let seen = camera_from_hand * place;
            let normal_seen = camera_from_hand * normal;
            let towards = -normal_seen.dot(&seen.coords);
            if towards < LEAST_COSINE * seen.coords.norm() {
                continue;
            }
            let ray = seen.coords / seen.z;
            let (u, v) = (camera.fx * ray.x + camera.cx, camera.fy * ray.y + camera.cy);
            let (column, row) = (u.round() as usize, v.round() as usize);
            if u < 0.0 || v < 0.0 || column >= image.width || row >= image.height {
                continue;
            }
            let nearest_m = 1.0 / f64::from(image.per_m[row * image.width + column]);
            if (nearest_m - seen.z).abs() > 0.002 {
                continue;
            }
            let pixels = camera.fx * camera.fy * area_m2 * towards / seen.z.powi(3);
            seen_px += pixels;
            if dent == Dent::Useless && self.is_dented(corners, &normal) {
                continue;
            }
            let weight = pixels / self.variance_m2(seen.z, alike_px);
            let mut slopes = DVector::zeros(UNKNOWNS);
            let slope = |moved: Vector3<f64>| normal_seen.dot(&moved) / normal_seen.dot(&ray);
            for (index, moves) in self.moves.iter().enumerate() {
                if let Some(moves) = moves {
                    let moved = corners.iter().map(|&corner| moves[corner as usize]);
                    slopes[index] = slope(camera_from_hand * (moved.sum::<Vector3<f64>>() / 3.0));
                }
            }
            for axis in 0..3 {
                let along = Vector3::ith(axis, 1.0);
                let turned = along.cross(&(place - middle));
                slopes[IN_HAND + axis] = slope(camera_from_hand * turned);
                slopes[IN_HAND + 3 + axis] = slope(camera_from_hand * along);
                slopes[MOUNT + axis] = slope(along.cross(&seen.coords));
                slopes[MOUNT + 3 + axis] = slope(along);
            }
            information.ger(weight, &slopes, &slopes, 1.0);
        }
        seen_px
    }

    /// Of a pixel's depth, as if neighbours were independent.
    fn variance_m2(&self, z_m: f64, alike_px: f64) -> f64 {
        let noise = &self.setup.noise;
        let sigma_m =
            z_m * z_m * noise.disparity_sigma_px / (self.setup.camera.fx * noise.baseline_m);
        let shared = noise.correlated_share;
        sigma_m.powi(2) * (1.0 - shared + alike_px * shared) + ROUNDING_M.powi(2)
    }

    fn is_dented(&self, corners: &[u32; 3], normal: &Vector3<f64>) -> bool {
        corners.iter().any(|&corner| {
            let corner = corner as usize;
            let moved = self.surface.vertices[corner] - self.undented.vertices[corner];
            moved.cast::<f64>().dot(normal).abs() > DENTED_M
        })
    }

    fn middle(&self) -> Point3<f64> {
        let (min, max) = self.surface.bounds();
        nalgebra::center(&min, &max).cast()
    }
}

/// The nearest graspable vertex above another at the same angle about the axis, and how much higher it is, m.
fn above(mesh: &Mesh, region: &[u32], handle: u32) -> Option<(u32, f64)> {
    let angle = |vertex: u32| {
        let place = mesh.vertices[vertex as usize];
        f64::from(place.y.atan2(place.x))
    };
    let higher_m = |vertex: u32| {
        f64::from(mesh.vertices[vertex as usize].z - mesh.vertices[handle as usize].z)
    };
    let is_same_side = |vertex: &u32| {
        let apart = (angle(*vertex) - angle(handle)).rem_euclid(TAU);
        apart.min(TAU - apart) < 1e-3 && higher_m(*vertex).abs() > 1e-5
    };
    let beside = region.iter().copied().filter(is_same_side);
    beside
        .map(|vertex| (vertex, higher_m(vertex)))
        .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// The object's vertices are the last of the scene's.
fn object(setup: &Setup, mesh: &Mesh) -> Mesh {
    let all = &setup.scene.hand.vertices;
    Mesh {
        vertices: all[all.len() - mesh.vertices.len()..].to_vec(),
        triangles: mesh.triangles.clone(),
    }
}

/// Whether the crop keeps a place in the hand's frame: above the gripper's plane, and no finger.
fn is_kept(place: &Point3<f64>) -> bool {
    let crop = roi_crop::Parameters::default();
    let is_beside_finger = place.x.abs() < 0.5 * crop.finger_width_m + crop.finger_margin_m
        && place.y.abs() > crop.finger_inner_m
        && place.z < crop.gripper_length_m + crop.finger_margin_m;
    place.z > f64::from(OBJECT_BOTTOM_Z_M) && !is_beside_finger
}

/// Information about each unknown before anything is seen: of what is drawn evenly, 1 over its variance.
fn prior() -> DVector<f64> {
    let parameters = ScanParameters::default();
    let of = |sigma: f64| 1.0 / (sigma * sigma);
    let mut prior = DVector::zeros(UNKNOWNS);
    // The size is to be found from the views alone.
    prior.rows_mut(0, 2).fill(of(0.1));
    let [least_m, most_m] = parameters.squeeze_m;
    prior[2] = of((most_m - least_m) / 12.0_f64.sqrt());
    prior[3] = of(0.02);
    let lean = of(parameters.grasp_lean_rad / 6.0_f64.sqrt());
    prior.rows_mut(IN_HAND, 2).fill(lean);
    prior[IN_HAND + 2] = of(TAU);
    prior
        .rows_mut(IN_HAND + 3, 3)
        .fill(of(parameters.grasp_shift_m / 3.0_f64.sqrt()));
    prior
        .rows_mut(MOUNT, 3)
        .fill(of(parameters.mount_error_rad / 3.0));
    prior
        .rows_mut(MOUNT + 3, 3)
        .fill(of(parameters.mount_error_m / 3.0));
    prior
}
