//! Closed-form rigid alignment of paired points (the Kabsch or Umeyama algorithm): one step of point-to-point ICP.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Sums over pairs of points, from which the motion follows.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pairs {
    count: f64,
    from: Vector3<f64>,
    to: Vector3<f64>,
    to_from: Matrix3<f64>,
}

impl Pairs {
    /// Adds the pair of a point and the place that it should come to.
    pub(crate) fn add(&mut self, from: &Point3<f32>, to: &Point3<f32>) {
        let (from, to) = (from.coords.cast::<f64>(), to.coords.cast::<f64>());
        self.count += 1.0;
        self.from += from;
        self.to += to;
        self.to_from += to * from.transpose();
    }

    /// The motion with the least sum of squared distances (Umeyama 1991, without scale). `None` for fewer than three
    /// pairs, or where their points lie on a line, around which anything may turn.
    pub(crate) fn motion(&self) -> Option<Isometry3<f64>> {
        if self.count < 3.0 {
            return None;
        }
        let (from, to) = (self.from / self.count, self.to / self.count);
        let covariance = self.to_from / self.count - to * from.transpose();
        let svd = covariance.svd(true, true);
        let (u, v_t) = (svd.u?, svd.v_t?);
        let (largest, middle) = (svd.singular_values[0], svd.singular_values[1]);
        if middle <= 1e-9 * largest || largest <= 0.0 {
            return None;
        }
        // Without the sign, points in a plane could be mirrored instead of turned.
        let sign = (u.determinant() * v_t.determinant()).signum();
        let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t;
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Some(Isometry3::from_parts(
            Translation3::from(to - rotation * from),
            rotation,
        ))
    }
}
