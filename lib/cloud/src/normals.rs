//! Directions of surfaces.

use nalgebra::{Matrix3, SymmetricEigen, Unit, Vector3};

/// Sums from which the plane through points follows, without keeping the points.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    count: f64,
    sum: Vector3<f64>,
    products: Matrix3<f64>,
}

/// The plane that fits points best.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Of unit length; which of the two sides it points to is not determined.
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

    /// The best plane; `None` for fewer than three points, or for points on one line.
    pub fn plane(&self) -> Option<Plane> {
        if self.count < 3.0 {
            return None;
        }
        let eigen = SymmetricEigen::new(self.covariance());
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let variances = order.map(|index| eigen.eigenvalues[index].max(0.0));
        // On a line the second variance is nothing but rounding.
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
    fn points_on_a_line_or_too_few_have_no_plane() {
        assert_eq!(moments(&[[0.0; 3], [1.0; 3]]).plane(), None);
        assert_eq!(
            moments(&[[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]).plane(),
            None
        );
        assert_eq!(moments(&[[1.0; 3]; 4]).plane(), None);
    }
}
