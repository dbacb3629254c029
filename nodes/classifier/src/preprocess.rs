//! From an object's cloud to the network's input.

use std::num::NonZeroUsize;

use cloud::normals::Moments;
use cloud::{Tree, farthest_points};
use nalgebra::{Point3, UnitQuaternion, Vector3};

use crate::error::PreprocessError;
use crate::metadata::{Centring, ModelMetadata};

/// Points that a normal is estimated of: few enough to follow a dent, enough to average a camera's noise.
const NORMAL_NEIGHBOURS: NonZeroUsize = match NonZeroUsize::new(12) {
    Some(count) => count,
    None => NonZeroUsize::MIN,
};

/// Makes the network's input from an object's cloud: samples N points, turns `up` to +z, moves the
/// cloud to the origin and divides by the model's fixed length.
///
/// `points` in metres; `up` in their frame, of any length. Returns [3, N] row-major: all x, all
/// y, all z; for a network that takes normals [6, N], where theirs follow in the same way. The same
/// cloud always gives the same input.
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
            .filter(|sphere| sphere.median_distance_m < NEAR_SPHERE_M)
            .map(|sphere| sphere.centre.cast())
            .or_else(box_centre),
    };
    let centre = centre.unwrap_or_else(Point3::origin);
    let units_per_metre = (1.0 / model.metres_per_unit) as f32;
    let mut input = Vec::with_capacity(model.columns() * model.point_count);
    for axis in 0..3 {
        let coordinate = |&index: &usize| (turned[index][axis] - centre[axis]) * units_per_metre;
        input.extend(chosen.iter().map(coordinate));
    }
    if model.normals {
        let normals = normals(&turned, &chosen, &centre);
        (0..3).for_each(|axis| input.extend(normals.iter().map(|normal| normal[axis])));
    }
    Ok(input)
}

/// Unit normals of the chosen points, each of the plane through its nearest neighbours in the whole cloud, and turned
/// away from the centre. Without a plane it points away from the centre itself.
fn normals(points: &[Point3<f32>], chosen: &[usize], centre: &Point3<f32>) -> Vec<Vector3<f32>> {
    let Some(tree) = Tree::new(points) else {
        return Vec::new();
    };
    let normal = |&index: &usize| {
        let point = &points[index];
        let outward = point - centre;
        let mut moments = Moments::default();
        for neighbour in tree.nearest_n(point, NORMAL_NEIGHBOURS) {
            moments.add(&(points[neighbour.index] - point).cast());
        }
        let found = moments.plane().map(|plane| plane.normal.cast::<f32>());
        let normal = found.map_or_else(
            || outward.try_normalize(0.0).unwrap_or_else(Vector3::z),
            nalgebra::Unit::into_inner,
        );
        if normal.dot(&outward) < 0.0 {
            -normal
        } else {
            normal
        }
    };
    chosen.iter().map(normal).collect()
}

/// Half of the points must be this near to a sphere for its centre to mean something: a camera's noise, not a can's side.
const NEAR_SPHERE_M: f64 = 0.002;

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
