//! Operations on point clouds that several crates share, independent of ROS.
//!
//! A cloud is a slice of [`Point3<f32>`] in metres, in a frame that the caller knows. Every function is deterministic:
//! the same points in the same order give the same answer.

mod cells;
pub mod file;
pub mod neighbours;
pub mod normals;
pub mod outliers;
#[cfg(test)]
mod random;
pub mod sample;
mod sphere;
pub mod text;
pub mod voxel;

use nalgebra::{Isometry3, Point3, Vector3};

pub use file::{
    FileError, Surface, Unmeasured, read, read_surface, write_pcd, write_pcd_field, write_ply,
};
pub use neighbours::Tree;
pub use sample::{SampleError, farthest_points};
pub use sphere::{Sphere, sphere};
pub use voxel::VoxelError;

/// Points that are fit to compute with, and how many were not.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cloud {
    /// Finite points other than the origin, in the order of the source.
    pub points: Vec<Point3<f32>>,
    /// Number of points that were left out.
    pub dropped: Dropped,
}

/// How many points were no measurements.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Points with a NaN or infinite coordinate, as PCL writes where a camera saw nothing.
    pub non_finite: usize,
    /// Points at exactly (0, 0, 0), as librealsense writes where a camera saw nothing.
    pub zero: usize,
}

impl Dropped {
    /// Whether a point is a measurement, by the rule that all readers share. Counts it otherwise.
    fn is_measured(&mut self, point: &Point3<f32>) -> bool {
        let is_zero = *point == Point3::origin();
        self.non_finite += usize::from(!is_finite(point));
        self.zero += usize::from(is_zero);
        is_finite(point) && !is_zero
    }

    /// All of them.
    pub fn count(&self) -> usize {
        self.non_finite + self.zero
    }
}

impl Cloud {
    /// Removes points that are not finite or exactly (0, 0, 0).
    pub fn clean(points: impl IntoIterator<Item = Point3<f32>>) -> Self {
        let mut dropped = Dropped::default();
        let points = points
            .into_iter()
            .filter(|point| dropped.is_measured(point))
            .collect();
        Self { points, dropped }
    }
}

/// An axis-parallel box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Point3<f32>,
    /// Largest coordinates.
    pub max: Point3<f32>,
}

impl Bounds {
    /// Lengths of the sides.
    pub fn extent(&self) -> Vector3<f32> {
        self.max - self.min
    }

    /// Middle of the box.
    pub fn centre(&self) -> Point3<f32> {
        nalgebra::center(&self.min, &self.max)
    }
}

/// The smallest axis-parallel box around finite points; `None` for no points.
pub fn bounds(points: &[Point3<f32>]) -> Option<Bounds> {
    let first = *points.first()?;
    let start = Bounds {
        min: first,
        max: first,
    };
    Some(points.iter().fold(start, |bounds, point| Bounds {
        min: bounds.min.inf(point),
        max: bounds.max.sup(point),
    }))
}

/// The mean of the points, summed in double precision; `None` for no points.
pub fn centroid(points: &[Point3<f32>]) -> Option<Point3<f32>> {
    if points.is_empty() {
        return None;
    }
    let sum = points
        .iter()
        .fold(Vector3::zeros(), |sum: Vector3<f64>, point| {
            sum + point.coords.cast::<f64>()
        });
    Some(Point3::from((sum / points.len() as f64).cast::<f32>()))
}

/// Whether no coordinate is NaN or infinite.
pub fn is_finite(point: &Point3<f32>) -> bool {
    point.x.is_finite() && point.y.is_finite() && point.z.is_finite()
}

/// Maps points from frame `b` into frame `a`.
pub fn transformed(a_from_b: &Isometry3<f64>, points: &[Point3<f32>]) -> Vec<Point3<f32>> {
    let a_from_b: Isometry3<f32> = a_from_b.cast();
    // The matrix form costs half as much a point as the quaternion's.
    let rotation = a_from_b.rotation.to_rotation_matrix();
    let translation = a_from_b.translation.vector;
    points
        .iter()
        .map(|point| rotation * point + translation)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clean_counts_what_it_drops() {
        let cloud = Cloud::clean([
            Point3::new(1.0, 2.0, 3.0),
            Point3::new(f32::NAN, 0.0, 0.0),
            Point3::origin(),
            Point3::new(0.0, f32::INFINITY, 0.0),
        ]);
        assert_eq!(cloud.points, [Point3::new(1.0, 2.0, 3.0)]);
        assert_eq!(
            cloud.dropped,
            Dropped {
                non_finite: 2,
                zero: 1
            }
        );
    }

    #[test]
    fn bounds_and_centroid_of_nothing_are_none() {
        assert_eq!(bounds(&[]), None);
        assert_eq!(centroid(&[]), None);
    }

    #[test]
    fn bounds_and_centroid_of_two_points() {
        let points = [Point3::new(0.0, 4.0, 1.0), Point3::new(2.0, 0.0, 1.0)];
        let bounds = bounds(&points).map(|bounds| (bounds.centre(), bounds.extent()));
        assert_eq!(
            bounds,
            Some((Point3::new(1.0, 2.0, 1.0), Vector3::new(2.0, 4.0, 0.0)))
        );
        assert_eq!(centroid(&points), Some(Point3::new(1.0, 2.0, 1.0)));
    }

    #[test]
    fn transforming_forth_and_back_changes_nothing() {
        let a_from_b = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.4, 0.5, -0.6));
        let points = [Point3::new(0.3, 0.2, 0.1), Point3::new(-0.3, 0.0, 0.5)];
        let back = transformed(&a_from_b.inverse(), &transformed(&a_from_b, &points));
        for (point, back) in points.iter().zip(&back) {
            assert!((point - back).norm() < 1e-6, "{point} came back as {back}");
        }
    }
}
