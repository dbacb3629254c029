//! Simulated scans: what the graph makes of a specimen that turns before the camera.
//!
//! Only rendering is simulated. Depth threshold, registration and crop are the nodes' own code, so that a network
//! learns from what it will be fed.

use depth_threshold::{DepthImage, ThresholdError, Thresholder};
use icp_registration::Registrar;
use mesh::Mesh;
use nalgebra::{Point3, Vector3};
use parameter::ParameterError;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use roi_crop::{Crop, Cropper, Frame};
use sim_camera::{InverseDepth, Noise, Placement, Renderer, integrate, moments};

use crate::flank::lose_flank;
use crate::parameters::ScanParameters;
use crate::setup::Setup;
use crate::view::View;

/// A scan that cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum ScanError {
    /// A node refuses a setting.
    #[error(transparent)]
    Setting(#[from] ParameterError),
    /// The depth threshold refuses an image.
    #[error(transparent)]
    Image(#[from] ThresholdError),
}

/// The object's cloud, as it reaches the classifier.
#[derive(Debug, Clone)]
pub struct ScannedObject {
    /// Points in m.
    pub points: Vec<Point3<f32>>,
    /// Up direction in their frame.
    pub up: Vector3<f64>,
    /// How many views made the cloud; 0 for the whole surface, without a camera.
    pub view_count: usize,
    /// Whether a gripper held the object.
    pub held: bool,
    /// Whether registration took all views and stands behind their cloud; without, no answer counts as known.
    pub trusted: bool,
}

/// Scans an object (in its own frame: bottom centre, +z up). Gives the clouds after the first view, the second, ..., and
/// that of the last view alone.
///
/// A cloud that the nodes refuse or call empty, because the object is hardly in view, is left out.
///
/// # Errors
/// Settings that a node refuses.
pub fn scan(
    object: &Mesh,
    parameters: &ScanParameters,
    seed: u64,
) -> Result<Vec<ScannedObject>, ScanError> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let setup = Setup::random(object, parameters, &mut random);
    let mut views = capture(&setup, &mut random)?;
    if random.random_bool(parameters.flank_lost_share) {
        let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
        let [least_m, most_m] = parameters.flank_lost_m;
        let width_m = random.random_range(least_m..=most_m);
        lose_flank(&mut views, &setup, side, width_m as f32);
    }
    let mut objects = after_each_view(&setup, &views, parameters)?;
    if let [_, .., last] = views.as_slice() {
        objects.extend(after_each_view(
            &setup,
            std::slice::from_ref(last),
            parameters,
        )?);
    }
    Ok(objects)
}

/// The whole surface of an object in its own frame, evenly covered.
pub fn full_view(object: &Mesh, random: &mut Pcg64Mcg) -> ScannedObject {
    const POINTS: usize = 4096;
    ScannedObject {
        points: object.surface_points(POINTS, random),
        up: Vector3::z(),
        view_count: 0,
        held: false,
        trusted: true,
    }
}

/// An image of a wrist that rests or turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// Where the wrist is in the middle of the exposure, rad.
    pub wrist_rad: f64,
    /// How far it turns during the exposure, rad.
    pub turn_rad: f64,
    /// Where kinematics have it at the image's stamp, rad.
    pub believed_rad: f64,
}

impl Shot {
    /// Of a wrist that rests.
    pub fn at_rest(wrist_rad: f64) -> Self {
        Self {
            wrist_rad,
            turn_rad: 0.0,
            believed_rad: wrist_rad,
        }
    }
}

/// The views of a scan, one for each of the setup's wrist angles.
///
/// # Errors
/// Settings that a node refuses.
pub fn capture(setup: &Setup, random: &mut Pcg64Mcg) -> Result<Vec<View>, ScanError> {
    let shots: Vec<Shot> = setup
        .wrist_angles_rad
        .iter()
        .map(|wrist_rad| Shot::at_rest(*wrist_rad))
        .collect();
    capture_shots(setup, &shots, random)
}

/// The views that images show.
///
/// # Errors
/// Settings that a node refuses.
pub fn capture_shots(
    setup: &Setup,
    shots: &[Shot],
    random: &mut Pcg64Mcg,
) -> Result<Vec<View>, ScanError> {
    let camera = &setup.camera;
    let mut renderer = Renderer::new(setup.camera.clone());
    let mut noise = Noise::new(setup.noise.clone(), random.random())?;
    let mut thresholder = Thresholder::new(setup.threshold.clone())?;
    let mut views = Vec::with_capacity(shots.len());
    for shot in shots {
        let image = noise.apply(&exposed(setup, shot, &mut renderer), camera);
        let bytes = image.to_le_bytes();
        let image = DepthImage::of_millimetres(camera.width, camera.height, &bytes);
        let mut points = thresholder.points(&image, camera)?;
        points.retain(|point| setup.is_in_image(point));
        let believed_hand_from_camera =
            setup.camera_from_hand(shot.believed_rad).inverse() * setup.camera_from_believed_camera;
        views.push(View {
            points,
            believed_hand_from_camera,
        });
    }
    Ok(views)
}

/// What a shot exposes.
fn exposed(setup: &Setup, shot: &Shot, renderer: &mut Renderer) -> InverseDepth {
    let mut rendered = |wrist_rad: f64| {
        let placement = Placement {
            camera_from_hand: setup.camera_from_hand(wrist_rad),
            camera_from_links: Vec::new(),
            camera_from_base: None,
        };
        renderer.render(&setup.scene, &placement).clone()
    };
    if shot.turn_rad == 0.0 {
        return rendered(shot.wrist_rad);
    }
    let seen = moments().map(|share| rendered(shot.wrist_rad + share * shot.turn_rad));
    integrate(&seen)
}

/// The object's cloud after each view, registered and cropped by the nodes' code. A view that registration refuses is left
/// out, and so is a cloud that the crop calls empty.
///
/// # Errors
/// Settings that a node refuses.
pub fn after_each_view(
    setup: &Setup,
    views: &[View],
    parameters: &ScanParameters,
) -> Result<Vec<ScannedObject>, ScanError> {
    let mut registrar = Registrar::new(parameters.registration.clone())?;
    let cropper = Cropper::new(setup.crop.clone())?;
    let frame = if setup.held {
        Frame::Hand { opening_m: None }
    } else {
        Frame::Camera
    };
    let mut objects = Vec::new();
    let mut all_taken = true;
    for (index, view) in views.iter().enumerate() {
        let pose = setup.held.then_some(view.believed_hand_from_camera);
        if registrar.add_view(&view.points, pose).is_err() {
            all_taken = false;
            continue;
        }
        let cropped = cropper.crop(&registrar.cloud(), frame);
        let is_something = |crop: &Crop| cropper.is_object(crop.points.len());
        if let Some(Crop { points, up, .. }) = cropped.ok().filter(is_something) {
            objects.push(ScannedObject {
                points,
                up,
                view_count: index + 1,
                held: setup.held,
                trusted: all_taken && registrar.doubt().is_none(),
            });
        }
    }
    Ok(objects)
}
