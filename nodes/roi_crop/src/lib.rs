//! Cuts the object out of a registered cloud.
//!
//! In the hand frame (+z out along the gripper) the object is what is above the gripper's plane, near the hand's axis
//! and not a finger (paper, Sec. VI-C: the region above the gripper of wrist joint W2). Without kinematics the cloud is
//! in a camera's frame, and the object is what is above a given height. Either way stray points go last.

mod axis;
mod error;
mod openings;
mod parameters;

use cloud::{is_finite, outliers};
use nalgebra::{Point3, Vector3};
use parameter::ParameterError;

pub use axis::{Axis, AxisError};
pub use error::CropError;
pub use openings::Openings;
pub use parameters::Parameters;

/// Which frame a cloud is in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame {
    /// The hand's: +z is up along the gripper, ±y are the fingers' sides.
    Hand {
        /// Distance between the fingers' inner faces, m, where it is known.
        opening_m: Option<f64>,
    },
    /// A camera's, in which `up_axis` says where up is.
    Camera,
}

/// The object, and what was cut away around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Crop {
    /// Points of the object, m, in the frame of the input and in its order.
    pub points: Vec<Point3<f32>>,
    /// Unit vector of that frame which points up.
    pub up: Vector3<f64>,
    /// Where the other points went.
    pub removed: Removed,
}

/// Points cut away, by reason. Each counts once, for the first reason that holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Removed {
    /// Below the gripper's plane, or below `keep_above_m`.
    pub below_gripper: usize,
    /// Too far from the hand's axis, or too high.
    pub outside_cylinder: usize,
    /// On the fingers.
    pub on_fingers: usize,
    /// Strays with too few neighbours.
    pub outliers: usize,
}

impl Removed {
    /// All of them.
    pub fn total(&self) -> usize {
        self.below_gripper + self.outside_cylinder + self.on_fingers + self.outliers
    }
}

/// Crops clouds with parameters that were checked once.
#[derive(Debug, Clone)]
pub struct Cropper {
    parameters: Parameters,
}

impl Cropper {
    /// With these settings.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Ok(Self { parameters })
    }

    /// The object in a cloud (m, in the frame that `frame` names).
    ///
    /// # Errors
    /// No points, a point that is not finite, or nothing left of them.
    pub fn crop(&self, points: &[Point3<f32>], frame: Frame) -> Result<Crop, CropError> {
        if points.is_empty() {
            return Err(CropError::Empty);
        }
        if let Some(index) = points.iter().position(|point| !is_finite(point)) {
            return Err(CropError::NotFinite { index });
        }
        let region = match frame {
            Frame::Hand { opening_m } => Region::hand(&self.parameters, self.bounds(), opening_m),
            Frame::Camera => Region::camera(&self.parameters),
        };
        let mut removed = Removed::default();
        let mut kept = region.keep(points, &mut removed);
        self.drop_strays(&mut kept, &mut removed);
        if kept.is_empty() {
            return Err(CropError::nothing_left(points.len(), removed, frame));
        }
        Ok(Crop {
            points: kept,
            up: self.up(frame),
            removed,
        })
    }

    /// Unit vector that points up in a frame.
    pub fn up(&self, frame: Frame) -> Vector3<f64> {
        match frame {
            Frame::Hand { .. } => Vector3::z(),
            Frame::Camera => self.parameters.up_axis.vector(),
        }
    }

    /// The upright cylinder about the hand's axis in which the object is.
    pub fn bounds(&self) -> Bounds {
        let bottom_m = self.parameters.gripper_length_m - self.parameters.grasp_depth_m;
        Bounds {
            radius_m: self.parameters.radius_m,
            bottom_m,
            top_m: bottom_m + self.parameters.height_m,
        }
    }

    /// Whether so many points are an object; fewer are what noise and the gripper leave of an empty hand.
    pub fn is_object(&self, point_count: usize) -> bool {
        point_count >= self.parameters.min_points
    }

    fn drop_strays(&self, points: &mut Vec<Point3<f32>>, removed: &mut Removed) {
        let (radius_m, min_neighbours) = (
            self.parameters.stray_radius_m,
            self.parameters.stray_min_neighbours,
        );
        let mut is_inlier = outliers::radius(points, radius_m as f32, min_neighbours).into_iter();
        let before = points.len();
        points.retain(|_| is_inlier.next().unwrap_or(true));
        removed.outliers = before - points.len();
    }
}

/// An upright cylinder about the z axis of the hand frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Radius, m.
    pub radius_m: f64,
    /// Height of its lower end, m.
    pub bottom_m: f64,
    /// Height of its upper end, m.
    pub top_m: f64,
}

/// The part of space in which the object is.
struct Region {
    up: Vector3<f32>,
    above_m: f32,
    cylinder: Option<Cylinder>,
    fingers: Option<Fingers>,
}

/// Upright, about the z axis.
struct Cylinder {
    radius_sq: f32,
    top_m: f32,
}

/// Two boxes at ±y, open to the outside.
struct Fingers {
    half_width_m: f32,
    inner_m: f32,
    top_m: f32,
}

impl Region {
    fn hand(parameters: &Parameters, bounds: Bounds, opening_m: Option<f64>) -> Self {
        let Bounds {
            radius_m,
            bottom_m,
            top_m,
        } = bounds;
        let cylinder = Cylinder {
            radius_sq: (radius_m * radius_m) as f32,
            top_m: top_m as f32,
        };
        let fingers =
            (parameters.finger_width_m > 0.0).then(|| Fingers::new(parameters, opening_m));
        Self {
            up: Vector3::z(),
            above_m: bottom_m as f32,
            cylinder: Some(cylinder),
            fingers,
        }
    }

    fn camera(parameters: &Parameters) -> Self {
        let up = parameters.up_axis.vector().cast();
        Self {
            up,
            above_m: parameters.keep_above_m as f32,
            cylinder: None,
            fingers: None,
        }
    }

    fn keep(&self, points: &[Point3<f32>], removed: &mut Removed) -> Vec<Point3<f32>> {
        let mut kept = Vec::with_capacity(points.len());
        for point in points {
            if point.coords.dot(&self.up) <= self.above_m {
                removed.below_gripper += 1;
            } else if self
                .cylinder
                .as_ref()
                .is_some_and(|cylinder| !cylinder.holds(point))
            {
                removed.outside_cylinder += 1;
            } else if self
                .fingers
                .as_ref()
                .is_some_and(|fingers| fingers.hold(point))
            {
                removed.on_fingers += 1;
            } else {
                kept.push(*point);
            }
        }
        kept
    }
}

impl Cylinder {
    fn holds(&self, point: &Point3<f32>) -> bool {
        point.xy().coords.norm_squared() <= self.radius_sq && point.z <= self.top_m
    }
}

impl Fingers {
    /// All that is as far out as a finger counts: what is behind a finger cannot be seen, so hardly a point of the object
    /// is lost. With an unknown opening so does all that is as far out as a finger can be.
    fn new(parameters: &Parameters, opening_m: Option<f64>) -> Self {
        let margin_m = parameters.finger_margin_m;
        let inner_m = opening_m.map_or(parameters.finger_inner_m, |m| m / 2.0 - margin_m);
        Self {
            half_width_m: (parameters.finger_width_m / 2.0 + margin_m) as f32,
            inner_m: inner_m as f32,
            top_m: (parameters.gripper_length_m + margin_m) as f32,
        }
    }

    fn hold(&self, point: &Point3<f32>) -> bool {
        let is_beside = point.x.abs() <= self.half_width_m && point.y.abs() >= self.inner_m;
        is_beside && point.z <= self.top_m
    }
}

#[cfg(test)]
mod tests;
