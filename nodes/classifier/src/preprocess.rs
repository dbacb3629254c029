//! From an object's cloud to the network's input.

use cloud::farthest_points;
use nalgebra::{Point3, UnitQuaternion, Vector3};

use crate::error::PreprocessError;
use crate::metadata::{Centring, ModelMetadata};

/// Makes the network's input from an object's cloud: samples N points, turns `up` to +z, moves the
/// cloud to the origin and divides by the model's fixed length.
///
/// `points` in metres; `up` in their frame, of any length. Returns [3, N] row-major: all x, all
/// y, all z. The same cloud always gives the same input.
///
/// # Errors
/// Fewer than N points, a coordinate that is not finite, or an `up` without length.
pub fn preprocess(
    points: &[Point3<f32>],
    up: &Vector3<f64>,
    model: &ModelMetadata,
) -> Result<Vec<f32>, PreprocessError> {
    let model_from_cloud = rotation_between(up, &Vector3::z())?.cast::<f32>();
    let turned: Vec<Point3<f32>> = points.iter().map(|p| model_from_cloud * p).collect();
    let chosen = farthest_points(&turned, model.point_count)?;
    let box_centre = || cloud::bounds(&turned).map(|bounds| bounds.centre());
    let centre = match model.centring {
        Centring::Centroid => cloud::centroid(&turned),
        Centring::Box => box_centre(),
        Centring::Sphere => cloud::sphere(&turned)
            .map(|sphere| sphere.centre.cast())
            .or_else(box_centre),
    };
    let centre = centre.unwrap_or_else(Point3::origin);
    let units_per_metre = (1.0 / model.metres_per_unit) as f32;
    let mut input = Vec::with_capacity(3 * model.point_count);
    for axis in 0..3 {
        let coordinate = |&index: &usize| (turned[index][axis] - centre[axis]) * units_per_metre;
        input.extend(chosen.iter().map(coordinate));
    }
    Ok(input)
}

/// The smallest rotation that turns `from` to `to`.
///
/// # Errors
/// `from` without length, or not finite.
pub fn rotation_between(
    from: &Vector3<f64>,
    to: &Vector3<f64>,
) -> Result<UnitQuaternion<f64>, PreprocessError> {
    let length = from.norm();
    if !length.is_finite() || length < 1e-9 {
        return Err(PreprocessError::NoUp([from.x, from.y, from.z]));
    }
    // No rotation is smallest between opposite directions: any half turn about a normal does.
    Ok(
        UnitQuaternion::rotation_between(from, to).unwrap_or_else(|| {
            let normal = from.cross(&least_aligned_axis(from));
            UnitQuaternion::from_axis_angle(
                &nalgebra::Unit::new_normalize(normal),
                std::f64::consts::PI,
            )
        }),
    )
}

fn least_aligned_axis(direction: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}
