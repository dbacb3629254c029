//! One dent of the answer.

use nalgebra::{Isometry3, Point3, UnitVector3};

use crate::dents::Patch;
use crate::placement::Placement;

/// A place where the object lies inside of its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Dent {
    /// The middle of its deepest part, on the undeformed surface, in the object's frame (bottom centre, +z up), m.
    pub centre_in_object: Point3<f64>,
    /// Outward there.
    pub direction_in_object: UnitVector3<f64>,
    /// The same in the frame of the cloud.
    pub centre: Point3<f64>,
    /// Outward there.
    pub direction: UnitVector3<f64>,
    /// Along the direction, m.
    pub depth_m: f64,
    /// Standard deviation of the depth, m.
    pub depth_sigma_m: f64,
    /// How broad the dented part that was seen is, along the horizontal of the object, m.
    pub width_m: f64,
    /// And along its vertical.
    pub height_m: f64,
    /// Its area, m².
    pub area_m2: f64,
    /// By how many standard deviations of what the camera measures there it lies inside.
    pub significance: f64,
}

/// What was seen of a dent, in the frames of the answer.
pub(crate) fn dent(patch: &Patch, placement: &Placement) -> Dent {
    let cloud_from_object: Isometry3<f64> = placement.object_from_cloud.inverse();
    let centre_in_object = placement.in_object(&patch.centre);
    let direction_in_object = UnitVector3::new_normalize(patch.normal);
    Dent {
        centre: cloud_from_object * centre_in_object,
        direction: cloud_from_object.rotation * direction_in_object,
        centre_in_object,
        direction_in_object,
        depth_m: patch.depth_m,
        depth_sigma_m: patch.depth_sigma_m,
        width_m: patch.width_m,
        height_m: patch.height_m,
        area_m2: patch.area_m2,
        significance: patch.significance,
    }
}
