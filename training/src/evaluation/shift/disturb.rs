//! What is done to a scan in each shift.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_distr::{Distribution, UnitSphere};
use rand_pcg::Pcg64Mcg;
use sim_camera::{D435I, Intrinsics};
use sim_scan::{ScanParameters, Setup, View, lose_flank, object_in};

/// One thing that is otherwise than in training.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shift {
    /// Nothing.
    None,
    /// The camera mount is off by exactly this, in random directions.
    Mount {
        /// Its direction.
        turn_rad: f64,
        /// Its position.
        move_m: f64,
    },
    /// Each view's pose is turned about the hand's origin, round a random axis: what joints between views get wrong.
    Joints(f64),
    /// Views after the first are stamped while the wrist has yet to turn by this angle: the clocks' difference times its rate.
    Late(f64),
    /// Standard deviation of disparity, in pixels.
    Noise(f64),
    /// So much of one side of the object, as the camera sees it, is without depth in each view, m: shiny metal at a
    /// grazing angle. Which side it is stays the same during a scan.
    Flank(f64),
    /// Three round holes of this radius, m, where the camera sees the object: glare stays where it is while the object turns.
    Glare(f64),
    /// Chance that a pixel beside a depth edge lies between the two surfaces; none is left out.
    Bleeding(f64),
    /// The camera's distance from the object's axis, m.
    Distance(f64),
    /// Another camera.
    Camera(Camera),
    /// The crop's plane is so much higher, m.
    Plane(f64),
    /// Depth of the gripper's dent, m; no specimen is without.
    Dent(f64),
}

/// Cameras that were not trained on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Camera {
    /// A D435i's depth aligned to its colour image of 320 x 240.
    Aligned320,
    /// A D435i at 1280 x 720.
    Full1280,
    /// Kinect of 2010 at 640 x 480.
    Kinect,
}

impl Camera {
    /// Its pinhole model, baseline (m) and standard deviation of disparity (pixels).
    ///
    /// A D435i has a focal length of 418 pixels at 848 x 480, and so 631 at 1280 x 720; its colour image at 320 x 240 has 307. Kinect: 585 pixels and 75 mm, depth error 1.43 mm at 1 m, growing with the square
    /// (Khoshelham and Elberink 2012), so 0.063 px.
    fn model(self) -> (Intrinsics, f64, f64) {
        let pinhole = |focal_px, width: u32, height: u32| Intrinsics {
            fx: focal_px,
            fy: focal_px,
            cx: 0.5 * f64::from(width - 1),
            cy: 0.5 * f64::from(height - 1),
            width,
            height,
        };
        const D435I_BASELINE_M: f64 = 0.04986;
        match self {
            Self::Aligned320 => (pinhole(307.0, 320, 240), D435I_BASELINE_M, 0.08),
            Self::Full1280 => (pinhole(631.0, 1280, 720), D435I_BASELINE_M, 0.08),
            Self::Kinect => (pinhole(585.0, 640, 480), 0.075, 0.063),
        }
    }
}

impl Shift {
    /// Changes what scans are drawn from.
    pub fn range(self, parameters: &mut ScanParameters) {
        match self {
            Self::Distance(distance_m) => parameters.distance_m = [distance_m; 2],
            // Nearer, it measures nothing (its data sheet says 0.8 m).
            Self::Camera(Camera::Kinect) => parameters.distance_m = [0.8, 1.0],
            _ => {}
        }
    }

    /// Changes how one scan is made.
    pub fn circumstances(self, setup: &mut Setup, random: &mut Pcg64Mcg) {
        match self {
            Self::Mount { turn_rad, move_m } => {
                setup.camera_from_believed_camera = Isometry3::from_parts(
                    Translation3::from(direction(random) * move_m),
                    UnitQuaternion::from_scaled_axis(direction(random) * turn_rad),
                );
            }
            Self::Noise(sigma_px) => setup.noise.disparity_sigma_px = sigma_px,
            Self::Bleeding(chance) => {
                setup.noise.edge_mixing = chance;
                setup.noise.edge_dropout = 0.0;
            }
            Self::Distance(_) => {
                setup.camera = D435I;
                see_all(setup);
            }
            Self::Camera(camera) => {
                let (intrinsics, baseline_m, sigma_px) = camera.model();
                setup.camera = intrinsics;
                setup.noise.baseline_m = baseline_m;
                setup.noise.disparity_sigma_px = sigma_px;
                see_all(setup);
            }
            Self::Plane(higher_m) => setup.crop.grasp_depth_m -= higher_m,
            _ => {}
        }
    }

    /// Changes what was seen, or what kinematics say of it.
    pub fn views(self, views: &mut [View], setup: &Setup, random: &mut Pcg64Mcg) {
        match self {
            Self::Joints(turn_rad) => {
                for view in views {
                    let off = UnitQuaternion::from_scaled_axis(direction(random) * turn_rad);
                    view.believed_hand_from_camera = off * view.believed_hand_from_camera;
                }
            }
            Self::Late(turn_rad) => {
                let off = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad);
                for view in views.iter_mut().skip(1) {
                    view.believed_hand_from_camera = off * view.believed_hand_from_camera;
                }
            }
            Self::Flank(width_m) => {
                let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
                lose_flank(views, setup, side, width_m as f32);
            }
            Self::Glare(radius_m) => {
                let (Some(first), Some(&wrist_rad)) =
                    (views.first(), setup.wrist_angles_rad.first())
                else {
                    return;
                };
                let object = object_in(first, setup, wrist_rad);
                let seen: Vec<Point3<f32>> = first
                    .points
                    .iter()
                    .zip(&object)
                    .filter_map(|(point, is_object)| is_object.then_some(*point))
                    .collect();
                let holes: Vec<Point3<f32>> = (0..3)
                    .filter_map(|_| seen.choose(random).copied())
                    .collect();
                let is_seen = |point: &Point3<f32>| {
                    let apart = |hole: &Point3<f32>| (point.xy() - hole.xy()).norm();
                    holes.iter().all(|hole| f64::from(apart(hole)) > radius_m)
                };
                for view in views {
                    view.points.retain(is_seen);
                }
            }
            _ => {}
        }
    }
}

/// Takes what is farther or nearer than a scan's usual range, as a user with such a camera would set it.
fn see_all(setup: &mut Setup) {
    setup.threshold.depth_min_m = 0.05;
    setup.threshold.depth_max_m = 1.5;
}

fn direction(random: &mut Pcg64Mcg) -> Vector3<f64> {
    let direction: [f64; 3] = UnitSphere.sample(random);
    direction.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_see_as_wide_as_their_makers_say() {
        let wide_deg = |camera: Camera| {
            let (model, ..) = camera.model();
            (2.0 * (0.5 * f64::from(model.width) / model.fx).atan()).to_degrees()
        };
        assert!((wide_deg(Camera::Full1280) - 90.0).abs() < 4.0);
        assert!((wide_deg(Camera::Kinect) - 57.0).abs() < 2.0);
    }
}
