//! Which motions of a view its surfaces determine.

use nalgebra::{
    Isometry3, Matrix6, Point3, SymmetricEigen, Translation3, UnitQuaternion, Vector3, Vector6,
};

/// Six motions in comparable units, m: three turns about a centre, measured by how far they move a point at the mean radius,
/// and three shifts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Twists {
    centre: Point3<f64>,
    radius_m: f64,
}

impl Twists {
    /// Around the middle of these points; `None` for none, or if all are in one place.
    pub(crate) fn around(points: &[Point3<f32>]) -> Option<Self> {
        let centre: Point3<f64> = cloud::centroid(points)?.cast();
        let square = |point: &Point3<f32>| (point.cast::<f64>() - centre).norm_squared();
        let radius_m = (points.iter().map(square).sum::<f64>() / points.len() as f64).sqrt();
        (radius_m > 0.0).then_some(Self { centre, radius_m })
    }

    /// Radius at which turns are measured, m.
    pub(crate) fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// How far each motion by one unit moves the surface at this point along its normal.
    pub(crate) fn effect(&self, point: &Point3<f32>, normal: &Vector3<f32>) -> Vector6<f64> {
        let normal: Vector3<f64> = normal.cast();
        let turns = ((point.cast::<f64>() - self.centre) / self.radius_m).cross(&normal);
        Vector6::new(turns.x, turns.y, turns.z, normal.x, normal.y, normal.z)
    }

    /// The motion with these six amounts, m.
    pub(crate) fn motion(&self, amounts: &Vector6<f64>) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_scaled_axis(amounts.fixed_rows::<3>(0) / self.radius_m);
        let shift: Vector3<f64> = amounts.fixed_rows::<3>(3).into();
        let about_centre = self.centre - rotation * self.centre;
        Isometry3::from_parts(Translation3::from(about_centre + shift), rotation)
    }

    /// The six amounts of a motion, m: the inverse of [`Twists::motion`].
    pub(crate) fn amounts(&self, motion: &Isometry3<f64>) -> Vector6<f64> {
        let turn = motion.rotation.scaled_axis() * self.radius_m;
        let shift = motion * self.centre - self.centre;
        Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
    }
}

/// How exactly a view's place is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Certainty {
    /// The six motions that `information` speaks of.
    pub(crate) twists: Twists,
    /// Mean of `effect · effectᵀ` over the surface, nothing along directions that are not determined.
    pub(crate) information: Matrix6<f64>,
}

/// Which combinations of the six motions may be corrected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Freedom {
    /// Projects amounts onto what is determined.
    determined: Matrix6<f64>,
    /// How many combinations are not.
    pub(crate) degenerate_directions: usize,
}

impl Freedom {
    /// From the mean of `effect · effectᵀ` over the surface. A motion is degenerate whose mean squared effect is below
    /// `degenerate_below`: 1 would be a plane moved along its normal, 0 one moved along itself.
    pub(crate) fn new(mean_information: &Matrix6<f64>, degenerate_below: f64) -> Self {
        let eigen = SymmetricEigen::new(*mean_information);
        let mut determined = Matrix6::zeros();
        let mut degenerate_directions = 0;
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            if *value < degenerate_below {
                degenerate_directions += 1;
            } else {
                determined += vector * vector.transpose();
            }
        }
        Self {
            determined,
            degenerate_directions,
        }
    }

    /// The part of `information` that lies along determined directions.
    pub(crate) fn determined(&self, information: &Matrix6<f64>) -> Matrix6<f64> {
        self.determined * information * self.determined
    }

    /// The least-squares solution of `information · x = pull` among amounts along determined directions only.
    pub(crate) fn solve(&self, information: &Matrix6<f64>, pull: &Vector6<f64>) -> Vector6<f64> {
        let (project, scale) = (self.determined, information.trace());
        if scale <= 0.0 {
            return Vector6::zeros();
        }
        // Directions outside get a stiffness of their own and no pull, so that the whole can be inverted.
        let outside = (Matrix6::identity() - project) * scale;
        let constrained = project * information * project + outside;
        let solved = constrained
            .cholesky()
            .map(|cholesky| cholesky.solve(&(project * pull)));
        solved.map_or_else(Vector6::zeros, |amounts| project * amounts)
    }
}
