//! Robust sphere fit.

use nalgebra::{Matrix4, Point3, Vector3, Vector4};

use crate::{bounds, centroid};

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Its centre, in the frame of the cloud.
    pub centre: Point3<f64>,
    /// Its radius.
    pub radius_m: f64,
    /// Median distance of the points from the sphere's surface, m.
    pub median_distance_m: f64,
}

/// Least scale of Cauchy's weights: the noise of a depth camera. Points nearer to the sphere have almost full weight.
const SCALE_MIN_M: f64 = 0.001;
const ROUNDS: usize = 20;
/// The iteration has converged when the centre moves by less than this.
const STILL_M: f64 = 2e-6;
/// Points whose median distance is still above HOPELESS_M after this many rounds lie on no sphere; stop early.
const HOPELESS_AFTER: usize = 6;
const HOPELESS_M: f64 = 0.004;

/// Fits a sphere by iteratively reweighted least squares on |p|² = 2 c·p + (r² - |c|²) (Kåsa 1976). Cauchy's weights reduce
/// the influence of points far from the previous sphere, so that a dent does not pull it.
///
/// `None` if the points determine no sphere, or one whose centre is far outside of them.
pub fn sphere(points: &[Point3<f32>]) -> Option<Sphere> {
    let bounds = bounds(points)?;
    let origin = centroid(points)?;
    let points: Vec<Vector3<f64>> = points.iter().map(|p| (p - origin).cast()).collect();
    let mut sphere = fit(&points, |_| 1.0)?;
    for round in 0..ROUNDS {
        if round >= HOPELESS_AFTER && sphere.median_distance_m > HOPELESS_M {
            break;
        }
        let scale_m = (0.5 * sphere.median_distance_m).max(SCALE_MIN_M);
        let (centre, radius_m) = (sphere.centre.coords, sphere.radius_m);
        sphere = fit(&points, |p| {
            let distance_m = (p - centre).norm() - radius_m;
            (1.0 + (distance_m / scale_m).powi(2)).powi(-2)
        })?;
        if (sphere.centre.coords - centre).norm() < STILL_M {
            break;
        }
    }
    let centre = origin.cast::<f64>() + sphere.centre.coords;
    let half_m = 0.5 * f64::from(bounds.extent().max());
    let low = bounds.min.cast::<f64>() - Vector3::repeat(half_m);
    let high = bounds.max.cast::<f64>() + Vector3::repeat(half_m);
    let is_near = low <= centre && centre <= high;
    is_near.then_some(Sphere { centre, ..sphere })
}

fn fit(points: &[Vector3<f64>], weight: impl Fn(&Vector3<f64>) -> f64) -> Option<Sphere> {
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for point in points {
        let row = Vector4::new(2.0 * point.x, 2.0 * point.y, 2.0 * point.z, 1.0);
        let weighted = weight(point) * row;
        normal += weighted * row.transpose();
        right += weighted * point.norm_squared();
    }
    let solved = normal.cholesky()?.solve(&right);
    let centre = Point3::from(solved.xyz());
    let radius_sq = solved.w + centre.coords.norm_squared();
    if !(radius_sq.is_finite() && radius_sq > 0.0) {
        return None;
    }
    let radius_m = radius_sq.sqrt();
    let distance_m = |p: &Vector3<f64>| ((p - centre.coords).norm() - radius_m).abs();
    let mut distances_m: Vec<f64> = points.iter().map(distance_m).collect();
    let middle = distances_m.len() / 2;
    let (_, median_distance_m, _) = distances_m.select_nth_unstable_by(middle, f64::total_cmp);
    Some(Sphere {
        centre,
        radius_m,
        median_distance_m: *median_distance_m,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, UnitSphere};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Half of a ball, as a camera sees it, with a flat dent and a little noise.
    fn dented_half(radius_m: f32, seed: u64) -> Vec<Point3<f32>> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let centre = Vector3::new(0.3, -0.2, 0.5);
        let mut points = Vec::new();
        while points.len() < 2000 {
            let direction: [f32; 3] = UnitSphere.sample(&mut random);
            let mut direction = Vector3::from(direction);
            direction.z = -direction.z.abs();
            let mut on_ball = direction * (radius_m + random.random_range(-0.0005..0.0005));
            on_ball.x = on_ball.x.min(0.8 * radius_m);
            points.push(Point3::from(centre + on_ball));
        }
        points
    }

    #[test]
    fn a_dent_does_not_pull_the_sphere() {
        for seed in 0..20 {
            let sphere = sphere(&dented_half(0.032, seed)).unwrap();
            assert!(
                (sphere.radius_m - 0.032).abs() < 1.5e-4,
                "seed {seed}: {sphere:?}"
            );
            assert!(sphere.median_distance_m < 0.0005, "seed {seed}: {sphere:?}");
            let off_m = (sphere.centre - Point3::new(0.3, -0.2, 0.5)).norm();
            assert!(off_m < 3e-4, "seed {seed}: {off_m} m");
        }
    }

    #[test]
    fn what_lies_on_no_sphere_has_none() {
        let plane: Vec<_> = (0..400)
            .map(|k| Point3::new(0.001 * (k % 20) as f32, 0.001 * (k / 20) as f32, 0.4))
            .collect();
        for points in [&plane[..], &plane[..20], &plane[..1], &[]] {
            assert_eq!(sphere(points), None, "{} points", points.len());
        }
    }
}
