//! Surface normals of point clouds.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Unit, Vector3};

use crate::voxel::{Grid, VoxelError};

/// Least number of points of a patch: the normal of fewer is mostly noise.
const PATCH_POINTS_MIN: usize = 6;
/// A patch is flat if the variance across it is below this share of that along its shorter side. Noise of 0.9 mm, that of
/// a D435i at half a metre, makes 0.15 of a patch of 8 mm.
const FLAT_BELOW: f64 = 0.15;

/// The unit normal of the surface at each point (m): that of the plane through its patch, the points in the same cube of
/// side `patch_m`. Which of the two sides it looks to is not determined. `None` where a patch is not flat, or has fewer
/// than six points.
///
/// Fitting one plane for each cube costs a hundredth of fitting one for each point.
///
/// # Errors
/// A side that is not positive, or a point too far from the origin for it.
pub fn of_patches(
    points: &[Point3<f32>],
    patch_m: f32,
) -> Result<Vec<Option<Vector3<f32>>>, VoxelError> {
    let mut patches = Grid::new(patch_m)?;
    patches.extend(points)?;
    let patch_of: Vec<Option<usize>> = points.iter().map(|point| patches.cell_of(point)).collect();
    let mut moments = vec![Moments::default(); patches.len()];
    for (point, patch) in points.iter().zip(&patch_of) {
        if let Some(patch) = *patch {
            moments[patch].add(&point.coords.cast());
        }
    }
    let normals: Vec<_> = moments.iter().map(Moments::flat_normal).collect();
    Ok(patch_of.into_iter().map(|patch| normals[patch?]).collect())
}

/// Flips normals so that each faces the viewpoint `eye` (all in one frame, m).
pub fn towards(eye: &Point3<f32>, points: &[Point3<f32>], normals: &mut [Option<Vector3<f32>>]) {
    for (point, normal) in points.iter().zip(normals) {
        if let Some(normal) = normal
            .as_mut()
            .filter(|normal| normal.dot(&(eye - point)) < 0.0)
        {
            *normal = -*normal;
        }
    }
}

/// Running sums of points (count, first and second moments), from which their best plane follows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    count: f64,
    sum: Vector3<f64>,
    products: Matrix3<f64>,
}

/// The plane that fits points best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal; its sign is arbitrary.
    pub normal: Unit<Vector3<f64>>,
    /// Variances along the three principal directions, smallest (along the normal) first, m².
    pub variances: [f64; 3],
}

impl Moments {
    /// Adds a point.
    pub fn add(&mut self, point: &Vector3<f64>) {
        self.count += 1.0;
        self.sum += point;
        self.products += point * point.transpose();
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.count as usize
    }

    /// Mean of the points; the origin for none.
    pub fn mean(&self) -> Vector3<f64> {
        self.sum / self.count.max(1.0)
    }

    /// Variance in every pair of directions, m².
    pub fn covariance(&self) -> Matrix3<f64> {
        let mean = self.mean();
        self.products / self.count.max(1.0) - mean * mean.transpose()
    }

    /// The normal of a flat patch.
    fn flat_normal(&self) -> Option<Vector3<f32>> {
        if self.count() < PATCH_POINTS_MIN {
            return None;
        }
        let plane = self.plane()?;
        let is_flat = plane.variances[0] < FLAT_BELOW * plane.variances[1];
        is_flat.then(|| plane.normal.into_inner().cast())
    }

    /// The best plane; `None` for fewer than three points, or for points on one line.
    pub fn plane(&self) -> Option<Plane> {
        if self.count < 3.0 {
            return None;
        }
        let eigen = SymmetricEigen::new(self.covariance());
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let variances = order.map(|index| eigen.eigenvalues[index].max(0.0));
        // For points on a line the second variance is only rounding.
        if variances[1] <= 1e-9 * variances[2] || variances[2] <= 0.0 {
            return None;
        }
        let normal = Unit::new_normalize(eigen.eigenvectors.column(order[0]).into_owned());
        Some(Plane { normal, variances })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn moments(points: &[[f64; 3]]) -> Moments {
        let mut moments = Moments::default();
        points.iter().for_each(|&point| moments.add(&point.into()));
        moments
    }

    #[test]
    fn a_tilted_plane_has_its_normal() {
        let normal = Vector3::new(1.0, 2.0, -2.0) / 3.0;
        let along = Vector3::new(2.0, 1.0, 2.0) / 3.0;
        let across = normal.cross(&along);
        let points: Vec<[f64; 3]> = (0..25)
            .map(|index| {
                along * f64::from(index % 5) + across * f64::from(index / 5) + normal * 7.0
            })
            .map(Into::into)
            .collect();
        let plane = moments(&points).plane().unwrap();
        assert!(plane.normal.dot(&normal).abs() > 1.0 - 1e-9);
        assert!(plane.variances[0] < 1e-9 && (plane.variances[2] - 2.0).abs() < 1e-9);
    }

    #[test]
    fn a_box_has_the_normals_of_its_sides_and_none_at_its_edges() {
        let steps = || (0..24).map(|step| 0.002 * step as f32 + 0.0005);
        let side = |x: f32, y: f32| [Point3::new(x, y, 0.0005), Point3::new(x, 0.0005, y)];
        let points: Vec<Point3<f32>> = steps()
            .flat_map(|x| steps().flat_map(move |y| side(x, y)))
            .collect();
        let eye = Point3::new(0.02, -0.3, -0.3);
        let mut normals = of_patches(&points, 0.008).unwrap();
        towards(&eye, &points, &mut normals);
        for (point, normal) in points.iter().zip(&normals) {
            let at_edge = point.y < 0.008 && point.z < 0.008;
            let expected = if point.z < 0.001 {
                -Vector3::z()
            } else {
                -Vector3::y()
            };
            assert_eq!(normal.is_none(), at_edge, "{point}: {normal:?}");
            assert!(normal.is_none_or(|normal| normal.dot(&expected) > 0.999));
        }
        assert!(of_patches(&points, 0.0).is_err());
        assert_eq!(of_patches(&points[..5], 0.008), Ok(vec![None; 5]));
    }

    #[test]
    fn points_on_a_line_or_too_few_have_no_plane() {
        assert_eq!(moments(&[[0.0; 3], [1.0; 3]]).plane(), None);
        assert_eq!(
            moments(&[[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]).plane(),
            None
        );
        assert_eq!(moments(&[[1.0; 3]; 4]).plane(), None);
    }
}
