//! One dent of the answer.

use nalgebra::{Point3, UnitVector3, Vector3};

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

impl Dent {
    /// A dent at a place of the reference's surface with this outward normal; what is measured of it is 0.
    pub(crate) fn at(centre: &Point3<f64>, normal: Vector3<f64>, placement: &Placement) -> Self {
        let cloud_from_object = placement.object_from_cloud.inverse();
        let centre_in_object = placement.in_object(centre);
        let direction_in_object = UnitVector3::new_normalize(normal);
        Self {
            centre: cloud_from_object * centre_in_object,
            direction: cloud_from_object.rotation * direction_in_object,
            centre_in_object,
            direction_in_object,
            depth_m: 0.0,
            depth_sigma_m: 0.0,
            width_m: 0.0,
            height_m: 0.0,
            area_m2: 0.0,
            significance: 0.0,
        }
    }

    /// The dent that a patch of the field shows.
    pub(crate) fn of(patch: &Patch, placement: &Placement) -> Self {
        Self {
            depth_m: patch.depth_m,
            depth_sigma_m: patch.depth_sigma_m,
            width_m: patch.width_m,
            height_m: patch.height_m,
            area_m2: patch.area_m2,
            significance: patch.significance,
            ..Self::at(&patch.centre, patch.normal, placement)
        }
    }
}
