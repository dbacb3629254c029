//! The linearised point-to-plane equations of one Gauss-Newton step: the distance of each point of a view from another
//! view's surface, and its derivative with respect to a motion of the mount.

use hand_eye::PATCHES_PER_VIEW;
use nalgebra::{Isometry3, Matrix6, Vector3, Vector6};

use super::surface::Surface;

/// Cosine of the largest angle between the normals of a pair.
const ALIKE: f64 = 0.8;
/// Scale of the robust weights, m: larger distances count less. Twice a D435i's noise at half a metre.
const ROBUST_M: f64 = 0.0015;
/// Surfaces nearer to each other than this agree, m: four times a D435i's noise at half a metre.
const AGREEMENT_M: f64 = 0.003;
/// A point whose nearest neighbour is farther away than this along the surface lies beyond what the other view saw, m.
const ASIDE_M: f64 = 0.004;

/// Sums over all pairs of points of all pairs of views.
#[derive(Debug, Clone, Default)]
pub(super) struct Equations {
    information: Matrix6<f64>,
    pull: Vector6<f64>,
    weight: f64,
    square_sum: f64,
    pairs: usize,
    agreeing: usize,
    views: usize,
}

impl Equations {
    /// Matches each view of a sweep with every other view of that sweep, with the mount moved by `found`.
    pub(super) fn gather(sweeps: &[Vec<Surface>], found: &Isometry3<f64>, reach_m: f32) -> Self {
        let mut equations = Self::default();
        for sweep in sweeps {
            equations.views += sweep.len();
            for (index, to) in sweep.iter().enumerate() {
                for from in sweep
                    .iter()
                    .enumerate()
                    .filter(|(other, _)| *other != index)
                {
                    equations.add_views(from.1, to, found, reach_m);
                }
            }
        }
        equations
    }

    pub(super) fn pairs(&self) -> usize {
        self.pairs
    }

    /// The share of the pairs whose surfaces agree.
    pub(super) fn agreeing(&self) -> f64 {
        self.agreeing as f64 / self.pairs.max(1) as f64
    }

    /// Root of the weighted mean square distance, m.
    pub(super) fn rms_m(&self) -> f64 {
        (self.square_sum / self.weight.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// The normal equations of a step from `found`, with the prior. Motions that the views do not determine stay at it.
    pub(super) fn with_prior(&self, found: &Isometry3<f64>) -> hand_eye::Equations {
        let scale = self.independent_share();
        let mut equations = hand_eye::Equations::prior(found);
        equations.add(&(self.information * scale), &(self.pull * scale));
        equations
    }

    /// Factor that turns sums over pairs into information: the number of independent measurements per pair over their
    /// variance.
    fn independent_share(&self) -> f64 {
        let variance = (self.rms_m() * self.rms_m()).max(VARIANCE_MIN_M2);
        self.views as f64 * PATCHES_PER_VIEW / (self.weight.max(1.0) * variance)
    }

    fn add_views(&mut self, from: &Surface, to: &Surface, found: &Isometry3<f64>, reach_m: f32) {
        let to_from_from = (to.hand_from_camera * found).inverse() * from.hand_from_camera * found;
        let turn = to_from_from.rotation.to_rotation_matrix();
        for (point, normal) in from.points.iter().zip(&from.normals) {
            let Some(normal) = normal else { continue };
            let (point, normal) = (point.cast::<f64>(), normal.cast::<f64>());
            let place = to_from_from * point;
            let near = to.tree.nearest(&place.cast());
            let Some(target_normal) = to.normals[near.index] else {
                continue;
            };
            let target_normal: Vector3<f64> = target_normal.cast();
            let is_alike = (turn * normal).dot(&target_normal) > ALIKE;
            let gap_m = (to.points[near.index].cast::<f64>() - place).dot(&target_normal);
            let aside_sq = f64::from(near.distance_sq) - gap_m * gap_m;
            if is_alike && near.distance_sq < reach_m * reach_m && aside_sq < ASIDE_M * ASIDE_M {
                // A motion of the mount moves both cameras: the point moves by the difference of both effects.
                let normal_there = turn.inverse() * target_normal;
                let about = point.coords.cross(&normal_there) - place.coords.cross(&target_normal);
                let along = normal_there - target_normal;
                self.add(
                    &Vector6::new(about.x, about.y, about.z, along.x, along.y, along.z),
                    gap_m,
                );
            }
        }
    }

    fn add(&mut self, effect: &Vector6<f64>, gap_m: f64) {
        let weight = 1.0 / (1.0 + (gap_m / ROBUST_M).powi(2));
        self.information += effect * effect.transpose() * weight;
        self.pull += effect * (gap_m * weight);
        self.weight += weight;
        self.square_sum += weight * gap_m * gap_m;
        self.pairs += 1;
        self.agreeing += usize::from(gap_m.abs() < AGREEMENT_M);
    }
}

/// Lower bound of the variance (0.1 mm)², m²: clouds without noise would give none.
const VARIANCE_MIN_M2: f64 = 1e-8;
