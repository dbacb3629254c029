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

/// Samples of a large cloud that are judged together.
pub(crate) const SAMPLES: usize = 4;
/// Points that each of them is chosen of, by point of the sample: of fewer, it would be less even than one of the whole
/// cloud.
const CHOICE_MIN: usize = 4;

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
    Placed::new(points, up, model)?.input(0, 1)
}

/// The same of four parts of a large cloud, [4, 3 or 6, N]: every fourth point is in a part. That takes no more time than
/// one sample of all points, and a point that is off counts for one of them only. A small cloud is one part.
///
/// # Errors
/// As [`preprocess`].
pub fn preprocess_parts(
    points: &[Point3<f32>],
    up: &Vector3<f64>,
    model: &ModelMetadata,
) -> Result<Vec<f32>, PreprocessError> {
    let placed = Placed::new(points, up, model)?;
    let is_large = points.len() >= SAMPLES * CHOICE_MIN * model.point_count;
    let parts = if is_large { SAMPLES } else { 1 };
    let mut input = Vec::with_capacity(parts * model.columns() * model.point_count);
    for part in 0..parts {
        input.extend(placed.input(part, parts)?);
    }
    Ok(input)
}

/// A cloud turned upright, and the point of it that becomes the origin.
struct Placed<'a> {
    model: &'a ModelMetadata,
    points: Vec<Point3<f32>>,
    centre: Point3<f32>,
    /// Only for a network that takes normals.
    tree: Option<Tree>,
}

impl<'a> Placed<'a> {
    fn new(
        points: &[Point3<f32>],
        up: &Vector3<f64>,
        model: &'a ModelMetadata,
    ) -> Result<Self, PreprocessError> {
        let model_from_cloud = rotation_between(up, &Vector3::z())?.cast::<f32>();
        let points: Vec<Point3<f32>> = points.iter().map(|p| model_from_cloud * p).collect();
        let box_centre = || cloud::bounds(&points).map(|bounds| bounds.centre());
        let centre = match model.centring {
            Centring::Centroid => cloud::centroid(&points),
            Centring::Box => box_centre(),
            Centring::Sphere => cloud::sphere(&points)
                .filter(|sphere| sphere.median_distance_m < NEAR_SPHERE_M)
                .map(|sphere| sphere.centre.cast())
                .or_else(box_centre),
        };
        Ok(Self {
            model,
            centre: centre.unwrap_or_else(Point3::origin),
            tree: model.normals.then(|| Tree::new(&points)).flatten(),
            points,
        })
    }

    /// The network's input of every `parts`-th point, from the point of number `part` on.
    fn input(&self, part: usize, parts: usize) -> Result<Vec<f32>, PreprocessError> {
        let Self { model, centre, .. } = self;
        let of_part: Vec<_> = self
            .points
            .iter()
            .skip(part)
            .step_by(parts)
            .copied()
            .collect();
        let chosen: Vec<Point3<f32>> = farthest_points(&of_part, model.point_count)?
            .into_iter()
            .map(|index| of_part[index])
            .collect();
        let units_per_metre = (1.0 / model.metres_per_unit) as f32;
        let mut input = Vec::with_capacity(model.columns() * model.point_count);
        for axis in 0..3 {
            input.extend(
                chosen
                    .iter()
                    .map(|point| (point[axis] - centre[axis]) * units_per_metre),
            );
        }
        if let Some(tree) = &self.tree {
            let normal = |point| self.normal(tree, point);
            let normals: Vec<Vector3<f32>> = chosen.iter().map(normal).collect();
            (0..3).for_each(|axis| input.extend(normals.iter().map(|normal| normal[axis])));
        }
        Ok(input)
    }

    /// Unit normal at a point, of the plane through its nearest neighbours in the whole cloud, turned away from the centre.
    /// Without a plane it points away from the centre itself.
    fn normal(&self, tree: &Tree, point: &Point3<f32>) -> Vector3<f32> {
        let outward = point - self.centre;
        let mut moments = Moments::default();
        for neighbour in tree.nearest_n(point, NORMAL_NEIGHBOURS) {
            moments.add(&(self.points[neighbour.index] - point).cast());
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
    }
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
