//! Which points are a view.

use cloud::normals::Moments;
use nalgebra::{Isometry3, Point3};

use crate::error::RegistrationError;

/// No surface that a camera measures is as flat, variance across to variance along: 0.1 µm over 1 cm.
const FLAT_BELOW: f64 = 1e-10;

/// Refuses points (m) that have no surface, by name.
pub(crate) fn check_points(points: &[Point3<f32>], needed: usize) -> Result<(), RegistrationError> {
    let count = points.len();
    if count == 0 {
        return Err(RegistrationError::Empty);
    }
    if let Some(index) = points.iter().position(|point| !cloud::is_finite(point)) {
        return Err(RegistrationError::NotFinite { index });
    }
    if count < needed {
        return Err(RegistrationError::TooFew { count, needed });
    }
    let mut moments = Moments::default();
    // From the first point: far from the origin the products would lose what is small.
    points
        .iter()
        .for_each(|point| moments.add(&(point - points[0]).cast()));
    match moments.plane() {
        Some(plane) if plane.variances[0] <= FLAT_BELOW * plane.variances[1] => {
            Err(RegistrationError::Planar { count })
        }
        Some(_) => Ok(()),
        None => Err(RegistrationError::Collinear { count }),
    }
}

/// Refuses a pose of which a number is NaN or infinite.
pub(crate) fn check_pose(pose: &Isometry3<f64>) -> Result<(), RegistrationError> {
    let (shift, turn) = (&pose.translation.vector, &pose.rotation.coords);
    let mut numbers = shift.iter().chain(turn.iter());
    let is_finite = numbers.all(|number| number.is_finite());
    is_finite.then_some(()).ok_or(RegistrationError::BadPose)
}
