//! How the reference lies in a cloud.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

/// Pose and scale of the reference in the cloud's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Maps the cloud's frame into the object's.
    pub object_from_cloud: Isometry3<f64>,
    /// Width of the specimen divided by that of the reference.
    pub width_scale: f64,
    /// The same for its height.
    pub height_scale: f64,
}

impl Placement {
    /// A point of the cloud on the reference: in the object's frame, and scaled to its size.
    pub fn on_reference(&self, point: &Point3<f64>) -> Point3<f64> {
        self.scaled_down(&(self.object_from_cloud * point))
    }

    fn scaled_down(&self, p: &Point3<f64>) -> Point3<f64> {
        let (width, height) = (1.0 / self.width_scale, 1.0 / self.height_scale);
        Point3::new(p.x * width, p.y * width, p.z * height)
    }

    /// A place on the reference in the object's frame at the specimen's own size.
    pub fn in_object(&self, p: &Point3<f64>) -> Point3<f64> {
        let (width, height) = (self.width_scale, self.height_scale);
        Point3::new(p.x * width, p.y * width, p.z * height)
    }
}

/// A placement without any scaling.
pub(crate) fn unscaled(object_from_cloud: Isometry3<f64>) -> Placement {
    Placement {
        object_from_cloud,
        width_scale: 1.0,
        height_scale: 1.0,
    }
}

/// The rotation that takes `up` to z, by the shortest way.
pub(crate) fn upright(up: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(up, &Vector3::z())
        .unwrap_or_else(|| UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI))
}
