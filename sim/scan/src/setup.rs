//! What differs from scan to scan: the specimen, how it is held, where the camera is and what it gets wrong.

use std::f64::consts::{PI, TAU};

use mesh::Mesh;
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, UnitSphere};
use rand_pcg::Pcg64Mcg;
use sim_camera::{D435I, Intrinsics, NoiseParameters, OBJECT_BOTTOM_Z_M, Scene};

use crate::parameters::ScanParameters;

/// The part of a D435i's image in which the object is; the rest would only cost time. Wide enough on the left for the
/// band that only one imager sees.
const WINDOW: Intrinsics = Intrinsics {
    width: 440,
    height: 400,
    cx: D435I.cx - 204.0,
    cy: D435I.cy - 38.0,
    ..D435I
};

/// Least and largest standard deviation of disparity, in pixels.
pub const DISPARITY_SIGMA_PX: [f64; 2] = [0.04, 0.14];
/// Least and largest chance that a pixel beside a depth edge lies between the two surfaces.
pub const EDGE_MIXING: [f64; 2] = [0.0, 0.35];

/// One scan's circumstances.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Specimen and what holds it.
    pub scene: Scene,
    /// Whether that is the gripper, so that there are kinematics; otherwise the specimen stands on a box.
    pub held: bool,
    /// Wrist angle of each view.
    pub wrist_angles_rad: Vec<f64>,
    /// Error of the camera mount.
    pub camera_from_believed_camera: Isometry3<f64>,
    /// The camera's pinhole model.
    pub camera: Intrinsics,
    /// The camera's noise.
    pub noise: NoiseParameters,
    /// The depth threshold's settings.
    pub threshold: depth_threshold::Parameters,
    /// The crop's settings.
    pub crop: roi_crop::Parameters,
    /// Row direction (y of the optical frame) above which the image ends, m.
    image_top_m: f32,
    camera_from_stand: Isometry3<f64>,
    stand_from_unturned_hand: Isometry3<f64>,
}

impl Setup {
    /// Circumstances of a scan of an object (in its own frame: bottom centre, +z up) drawn from `random`; an empty hand for
    /// one without a surface.
    pub fn random(object: &Mesh, parameters: &ScanParameters, random: &mut Pcg64Mcg) -> Self {
        let specimen = grasped(object, parameters, random);
        let is_nothing = object.triangles.is_empty();
        let height_m = if is_nothing {
            0.1
        } else {
            f64::from(specimen.bounds().1.z)
        };
        let held = !random.random_bool(parameters.table_share) || is_nothing;
        let camera_from_stand = camera_pose(held, height_m, parameters, random);
        let scene = if is_nothing {
            Scene::empty_handed()
        } else if held {
            Scene::holding(&specimen)
        } else {
            standing(&specimen, random)
        };
        let (crop, image_top_m) = if held {
            (roi_crop::Parameters::default(), f32::NEG_INFINITY)
        } else {
            box_cut_away(&camera_from_stand, height_m, random)
        };
        let lean_rad = if held { parameters.wrist_lean_rad } else { 0.0 };
        let step_rad = if held {
            parameters.view_step_rad
        } else {
            between(parameters.table_step_rad, random)
        };
        let start_rad = random.random_range(0.0..TAU);
        let wrist_angles_rad = (0..parameters.view_count)
            .map(|view| start_rad + step_rad * view as f64 + random.random_range(-0.02..=0.02))
            .collect();
        Self {
            scene,
            held,
            wrist_angles_rad,
            camera_from_believed_camera: Translation3::from(within_ball(
                parameters.mount_error_m,
                random,
            )) * UnitQuaternion::from_scaled_axis(within_ball(
                parameters.mount_error_rad,
                random,
            )),
            camera: WINDOW,
            noise: noise(random),
            threshold: threshold(random),
            crop,
            image_top_m,
            camera_from_stand,
            stand_from_unturned_hand: lean(lean_rad, random),
        }
    }

    /// Whether the image shows a point (m, optical frame).
    pub fn is_in_image(&self, point: &Point3<f32>) -> bool {
        point.y > self.image_top_m
    }

    /// The hand's pose before the camera with the wrist turned by an angle.
    pub fn camera_from_hand(&self, wrist_rad: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), wrist_rad);
        self.camera_from_stand * self.stand_from_unturned_hand * turn
    }
}

/// An object as the fingers have taken it: not quite upright and centred, and any way round.
fn grasped(object: &Mesh, parameters: &ScanParameters, random: &mut Pcg64Mcg) -> Mesh {
    let shift_m =
        Vector3::from_fn(|_, _| random.random_range(-1.0..=1.0)) * parameters.grasp_shift_m;
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.random_range(0.0..TAU));
    let grasp_from_object =
        Translation3::from(shift_m) * lean(parameters.grasp_lean_rad, random) * turn;
    object.transformed(&grasp_from_object.cast())
}

/// The object on a box, in the frame in which the hand would hold it.
fn standing(object: &Mesh, random: &mut Pcg64Mcg) -> Scene {
    let [half_x, half_y]: [f32; 2] = [0; 2].map(|_| random.random_range(0.05..0.15));
    let low = Point3::new(-half_x, -half_y, OBJECT_BOTTOM_Z_M - 0.10);
    let mut hand = Mesh::cuboid(low, Point3::new(half_x, half_y, OBJECT_BOTTOM_Z_M));
    hand.append(&object.transformed(&Translation3::new(0.0, 0.0, OBJECT_BOTTOM_Z_M).into()));
    Scene {
        hand,
        links: Vec::new(),
        wall_x_m: None,
    }
}

/// How a user crops what stands on a box, and where the image ends: sometimes a little below the object's top.
fn box_cut_away(
    camera_from_stand: &Isometry3<f64>,
    height_m: f64,
    random: &mut Pcg64Mcg,
) -> (roi_crop::Parameters, f32) {
    let down_m = |z_m: f64| {
        (camera_from_stand * Point3::new(0.0, 0.0, f64::from(OBJECT_BOTTOM_Z_M) + z_m)).y
    };
    let keep_above_m = -down_m(random.random_range(0.003..0.012));
    let hidden_m = if random.random_bool(0.4) {
        random.random_range(0.0..0.012)
    } else {
        -0.1
    };
    let crop = roi_crop::Parameters {
        keep_above_m,
        ..roi_crop::Parameters::default()
    };
    (crop, down_m(height_m - hidden_m) as f32)
}

/// Where the camera is: the object's stand in its optical frame (z forward, x right, y down).
fn camera_pose(
    held: bool,
    height_m: f64,
    parameters: &ScanParameters,
    random: &mut Pcg64Mcg,
) -> Isometry3<f64> {
    let (elevation_rad, distance_m) = if held {
        (parameters.elevation_rad, parameters.distance_m)
    } else {
        (parameters.table_elevation_rad, parameters.table_distance_m)
    };
    let elevation_rad = between(elevation_rad, random);
    let distance_m = between(distance_m, random);
    let middle = Vector3::new(0.0, 0.0, f64::from(OBJECT_BOTTOM_Z_M) + 0.5 * height_m);
    let forward = Vector3::new(elevation_rad.cos(), 0.0, -elevation_rad.sin());
    let right = forward.cross(&Vector3::z()).normalize();
    let stand_from_camera =
        Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
    let stand_from_camera = Translation3::from(middle - distance_m * forward)
        * UnitQuaternion::from_rotation_matrix(&stand_from_camera);
    // The object is not quite in the middle of the image, nor the camera quite level.
    let aim = Vector3::new(
        random.random_range(-0.1..0.1),
        random.random_range(-0.1..0.1),
        random.random_range(-0.03..0.03),
    );
    (stand_from_camera * UnitQuaternion::from_scaled_axis(aim)).inverse()
}

fn between([lowest, highest]: [f64; 2], random: &mut Pcg64Mcg) -> f64 {
    random.random_range(lowest..=highest)
}

/// A turn away from upright by up to an angle.
fn lean(largest_rad: f64, random: &mut Pcg64Mcg) -> Isometry3<f64> {
    let (angle_rad, towards_rad) = (
        random.random_range(0.0..=largest_rad),
        random.random_range(-PI..PI),
    );
    let axis = Vector3::new(towards_rad.cos(), towards_rad.sin(), 0.0);
    Isometry3::rotation(axis * angle_rad)
}

fn within_ball(radius: f64, random: &mut Pcg64Mcg) -> Vector3<f64> {
    let direction: [f64; 3] = UnitSphere.sample(random);
    Vector3::from(direction) * random.random_range(0.0..=radius)
}

/// From a better camera than usual to a worse one.
fn noise(random: &mut Pcg64Mcg) -> NoiseParameters {
    NoiseParameters {
        disparity_sigma_px: random.random_range(DISPARITY_SIGMA_PX[0]..DISPARITY_SIGMA_PX[1]),
        correlated_share: random.random_range(0.2..0.8),
        edge_dropout: random.random_range(0.0..0.6),
        edge_mixing: random.random_range(EDGE_MIXING[0]..EDGE_MIXING[1]),
        ..NoiseParameters::default()
    }
}

/// Each user's choice of the settings that change what points look like.
fn threshold(random: &mut Pcg64Mcg) -> depth_threshold::Parameters {
    let usual = depth_threshold::Parameters::default();
    let edge_jump_m = if random.random_bool(0.7) {
        usual.edge_jump_m
    } else {
        0.0
    };
    depth_threshold::Parameters {
        decimation: random.random_range(1..=2),
        edge_jump_m,
        ..usual
    }
}
